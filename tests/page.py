#!/usr/bin/env python3
"""Opens a report in Chromium as a reader does, folded parts opened, and fails if anything is wider than the page or is asked of
the network: python3 tests/page.py REPORT.html... Chromium is the program in $CHROMIUM, else `chromium`."""

import html
import os
import re
import subprocess
import sys
import tempfile

WIDTHS = [360, 390, 768, 1280]

# In the page, before anything else: whatever it would load is a violation, which is counted instead of loaded.
WATCH = """<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<script>asked = []; addEventListener('securitypolicyviolation', e => asked.push(e.blockedURI))</script>"""

# Around it: a frame a width, since a window cannot be as narrow as a phone. What scrolls in its own box is no overflow.
MEASURE = """
addEventListener('load', () => setTimeout(() => {
  const found = [];
  for (const frame of document.querySelectorAll('iframe')) {
    const page = frame.contentDocument, width = frame.clientWidth;
    page.querySelectorAll('details').forEach(d => { d.open = true });
    const scrolls = e => e && (/auto|scroll/.test(getComputedStyle(e).overflowX) && e !== page.documentElement || scrolls(e.parentElement));
    for (const e of page.body.querySelectorAll('*')) {
      const box = e.getBoundingClientRect();
      if ((box.right > width + 0.5 || box.left < -0.5) && !e.closest('svg *') && !scrolls(e.parentElement))
        found.push(`${width} px: <${e.tagName.toLowerCase()}> reaches from ${box.left} to ${box.right}: ${e.textContent.trim().slice(0, 60)}`);
    }
    if (page.documentElement.scrollWidth > width) found.push(`${width} px: the page is ${page.documentElement.scrollWidth} px wide`);
    if (!page.querySelector('figure svg, table')) found.push(`${width} px: nothing is shown`);
    frame.contentWindow.asked.forEach(uri => found.push(`asked of the network: ${uri}`));
  }
  document.title = 'measured';
  document.getElementById('found').textContent = found.join('\\n');
}, 200))
"""


def faults(file):
    with open(file, encoding="utf-8") as page:
        text = page.read().replace("<head>", "<head>" + WATCH, 1)
    frames = "".join(f'<iframe style="width:{w}px;height:900px;border:0" srcdoc="{html.escape(text)}"></iframe>' for w in WIDTHS)
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
