#!/usr/bin/env python3
"""Opens a report in Chromium as a reader does, light and dark, folded parts opened, and fails if anything is wider than the page, cannot be
read on its background, or is asked of the network: python3 tests/page.py REPORT.html... Chromium is the program in $CHROMIUM, else `chromium`."""

import html
import os
import re
import subprocess
import sys
import tempfile

WIDTHS = [360, 390, 768, 1280]
SCHEMES = ["light", "dark"]

# In the page, before anything else: whatever it would load is a violation, which is counted instead of loaded.
WATCH = """<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<script>asked = []; addEventListener('securitypolicyviolation', e => asked.push(e.blockedURI))</script>"""

# Around it: a frame a width and scheme, since a window cannot be as narrow as a phone; a page in a frame prefers the scheme of its frame. What
# scrolls in its own box is no overflow. Contrast is that of WCAG 2, whose level AA asks for 4.5.
MEASURE = """
addEventListener('load', () => setTimeout(() => {
  const found = [];
  const luminance = rgb => rgb.map(c => c / 255).map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
    .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
  const channels = colour => colour.match(/[\d.]+/g).map(Number);
  const background = e => {
    if (!e) return [255, 255, 255];
    const [r, g, b, a = 1] = channels(getComputedStyle(e).backgroundColor);
    return a > 0 ? [r, g, b] : background(e.parentElement);
  };
  for (const frame of document.querySelectorAll('iframe')) {
    const page = frame.contentDocument, scheme = frame.style.colorScheme, width = `${frame.clientWidth} px, ${scheme}`;
    const px = frame.clientWidth;
    page.querySelectorAll('details').forEach(d => { d.open = true });
    const scrolls = e => e && (/auto|scroll/.test(getComputedStyle(e).overflowX) && e !== page.documentElement || scrolls(e.parentElement));
    for (const e of page.body.querySelectorAll('*')) {
      const box = e.getBoundingClientRect();
      if ((box.right > px + 0.5 || box.left < -0.5) && !e.closest('svg *') && !scrolls(e.parentElement))
        found.push(`${width}: <${e.tagName.toLowerCase()}> reaches from ${box.left} to ${box.right}: ${e.textContent.trim().slice(0, 60)}`);
    }
    for (const e of page.body.querySelectorAll('*')) {
      if (e.closest('svg') || ![...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim())) continue;
      const [high, low] = [channels(getComputedStyle(e).color).slice(0, 3), background(e)].map(luminance).sort((a, b) => b - a);
      const contrast = (high + 0.05) / (low + 0.05);
      if (contrast < 4.5) found.push(`${width}: contrast ${contrast.toFixed(1)}: ${e.textContent.trim().slice(0, 60)}`);
    }
    if ((luminance(background(page.body)) < 0.5) !== (scheme === 'dark')) found.push(`${width}: the page is not ${scheme}`);
    if (page.documentElement.scrollWidth > px) found.push(`${width}: the page is ${page.documentElement.scrollWidth} px wide`);
    if (!page.querySelector('figure svg, table')) found.push(`${width}: nothing is shown`);
    frame.contentWindow.asked.forEach(uri => found.push(`asked of the network: ${uri}`));
  }
  document.title = 'measured';
  document.getElementById('found').textContent = found.join('\\n');
}, 200))
"""


def faults(file):
    with open(file, encoding="utf-8") as page:
        text = page.read().replace("<head>", "<head>" + WATCH, 1)
    frame = '<iframe style="width:{}px;height:900px;border:0;color-scheme:{}" srcdoc="{}"></iframe>'
    frames = "".join(frame.format(w, scheme, html.escape(text)) for w in WIDTHS for scheme in SCHEMES)
    with tempfile.TemporaryDirectory() as folder:
        wrapper = os.path.join(folder, "wrapper.html")
        with open(wrapper, "w", encoding="utf-8") as out:
            out.write(f'<!DOCTYPE html><meta charset="utf-8"><script>{MEASURE}</script><pre id="found"></pre>{frames}')
        command = [os.environ.get("CHROMIUM", "chromium"), "--headless", "--disable-gpu", "--no-first-run", "--window-size=1400,1000"]
        command += [f"--user-data-dir={folder}/profile", "--virtual-time-budget=10000", "--dump-dom", "file://" + wrapper]
        if os.name == "posix" and os.geteuid() == 0:
            command.append("--no-sandbox")
        shown = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True).stdout
    if "<title>measured</title>" not in shown:
        return ["Chromium did not measure the page"]
    return [line for line in html.unescape(re.search(r'<pre id="found">(.*?)</pre>', shown, re.S)[1]).splitlines() if line]


if __name__ == "__main__":
    failed = False
    for file in sys.argv[1:]:
        for fault in faults(file):
            failed = True
            print(f"{file}: {fault}", file=sys.stderr)
    sys.exit(failed or len(sys.argv) < 2)
