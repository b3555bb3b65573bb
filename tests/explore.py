#!/usr/bin/env python3
"""Drives the page of `cargo xtask explore` in Chromium as a person does, by mouse, keyboard and touch, and fails if a number differs
from what `trace` prints, a control does nothing, anything is wider than the page, asked of another address or written to the console, or
fewer than five frames a second follow a receiver that is dragged:

    python3 tests/explore.py XTASK_EXPLORE XTASK [--maps MAPS] [--map ID] [--pictures FOLDER]

XTASK_EXPLORE and XTASK are the programs. Chromium is the one in $CHROMIUM, else `chromium`. Prints the frames a second. With --pictures it keeps pictures of the page."""

import argparse
import base64
import fcntl
import json
import math
import os
import re
import shlex
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request
from contextlib import contextmanager

# Frames a second that a busy machine has too.
LEAST_FRAMES = 5.0

WIDTHS = [360, 390, 768, 1280]

# Elements that reach beyond the page; what scrolls in its own box does not count.
OVERFLOW = """(() => {
  const width = document.documentElement.clientWidth, found = [];
  const scrolls = e => e && (/auto|scroll/.test(getComputedStyle(e).overflowX) && e !== document.documentElement || scrolls(e.parentElement));
  for (const e of document.body.querySelectorAll('*')) {
    const box = e.getBoundingClientRect();
    if ((box.right > width + 0.5 || box.left < -0.5) && !e.closest('svg *') && !scrolls(e.parentElement))
      found.push(`${e.tagName} ${e.id} from ${box.left} to ${box.right}`);
  }
  if (document.documentElement.scrollWidth > width) found.push(`the page is ${document.documentElement.scrollWidth} px wide`);
  return found;
})()"""

# A terminal dragged to and fro along the line between two places on the screen, a step a frame: frames, frames with new paths,
# and the times between new paths.
DRAG = """new Promise(done => {
  const [end, x0, y0, x1, y1, seconds] = %s;
  const grip = document.getElementById(end), times = [];
  let began, frames = 0, drawn = explorer.drawn, last;
  const step = now => {
    began ??= now; last ??= now; frames += 1;
    if (explorer.drawn > drawn) { times.push(now - last); [drawn, last] = [explorer.drawn, now]; }
    if (now - began > 1000 * seconds) return done({ frames, drawn: times.length, seconds: (now - began) / 1000, longest: Math.max(...times) });
    const t = 0.5 - 0.5 * Math.cos(2 * Math.PI * (now - began) / 3000);
    grip.dispatchEvent(new PointerEvent('pointermove', { bubbles: true, clientX: x0 + t * (x1 - x0), clientY: y0 + t * (y1 - y0) }));
    requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
})"""


class Browser:
    """Chromium without a window, spoken to over a pipe."""

    def __init__(self, folder):
        to_read, self.out = os.pipe()
        self.into, to_write = os.pipe()
        # The program reads commands from 3 and writes answers to 4: out of the way of these first.
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (to_read, to_write)]

        def plumb():
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)

        command = [os.environ.get("CHROMIUM", "chromium"), "--headless=new", "--disable-gpu", "--no-first-run", "--hide-scrollbars"]
        command += ["--remote-debugging-pipe", f"--user-data-dir={folder}/profile", "--window-size=1280,900"]
        if os.name == "posix" and os.geteuid() == 0:
            command.append("--no-sandbox")
        self.process = subprocess.Popen(
            command, preexec_fn=plumb, pass_fds=(3, 4), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        for end in (to_read, to_write, *ends):
            os.close(end)
        self.rest, self.number, self.events = b"", 0, []

    def call(self, method, session=None, **params):
        """Calls a method; events that come meanwhile are kept."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": params}
        if session:
            message["sessionId"] = session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        while True:
            got = self.read()
            if got.get("id") == self.number:
                if "error" in got:
                    raise RuntimeError(f"{method}: {got['error']}")
                return got["result"]
            self.events.append(got)

    def read(self):
        while b"\0" not in self.rest:
            part = os.read(self.into, 1 << 20)
            if not part:
                raise RuntimeError("Chromium has gone")
            self.rest += part
        message, self.rest = self.rest.split(b"\0", 1)
        return json.loads(message)

    def close(self):
        self.call("Browser.close")
        self.process.wait(30)


class Page:
    """A tab."""

    def __init__(self, browser, url):
        self.browser, self.own = browser, url.split("#")[0]
        target = browser.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = browser.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.open(url)

    def call(self, method, **params):
        return self.browser.call(method, self.session, **params)

    def open(self, url):
        self.call("Page.navigate", url="about:blank")
        self.call("Page.navigate", url=url)
        self.wait("window.explorer?.drawn > 0 && explorer.compared > 0")

    def eval(self, script):
        got = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in got:
            raise RuntimeError(f"{script}: {got['exceptionDetails']}")
        return got["result"].get("value")

    def wait(self, condition, seconds=300):
        """Waits until a condition holds, looking once a frame."""
        look = f"""new Promise((yes, no) => {{
          const end = performance.now() + {1000 * seconds};
          const look = () => ({condition}) ? yes(true) : performance.now() > end ? yes(false) : setTimeout(look, 10);
          look();
        }})"""
        if not self.eval(look):
            raise AssertionError(f"never: {condition}; fault: {self.eval('document.getElementById(`fault`)?.textContent')}")

    def after(self, act):
        """Does something, and waits for paths and comparison that follow it."""
        counts = self.eval("[explorer.drawn, explorer.compared]")
        act()
        self.wait(f"explorer.drawn > {counts[0]} && explorer.compared > {counts[1]} && document.getElementById('progress').hidden")

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1 if kind != "mouseReleased" else 0, clickCount=1, **more)

    def drag(self, start, *stops):
        self.mouse("mousePressed", *start)
        for stop in stops:
            self.call("Input.dispatchMouseEvent", type="mouseMoved", x=stop[0], y=stop[1], button="left", buttons=1)
        self.mouse("mouseReleased", *stops[-1])

    def click(self, x, y):
        self.mouse("mousePressed", x, y)
        self.mouse("mouseReleased", x, y)

    def key(self, key, **more):
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, **more)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, **more)

    def screen(self, point):
        """Place on the screen of a place on the map."""
        return self.eval(f"""import('/city.js').then(city => {{
          document.getElementById('city').scrollIntoView({{ block: 'center' }});
          const svg = document.getElementById('map'), [x, y] = city.place({json.dumps(point)});
          const at = new DOMPoint(x, y).matrixTransform(svg.getScreenCTM());
          return [at.x, at.y];
        }})""")

    def state(self):
        return self.eval("import('/state.js').then(s => JSON.parse(JSON.stringify(s.state)))")

    def picture(self, file, dark=False, width=1280, height=900, scale=1):
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=width < 700)
        self.eval("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        if file:
            data = self.call("Page.captureScreenshot", format="png")["data"]
            with open(file, "wb") as out:
                out.write(base64.b64decode(data))

    def faults(self):
        """Lines of the console, and requests to others."""
        found = []
        for event in self.browser.events:
            if event.get("sessionId") != self.session:
                continue
            method, params = event["method"], event["params"]
            if method in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"):
                found.append(f"console: {json.dumps(params)[:400]}")
            if method == "Network.requestWillBeSent":
                url = params["request"]["url"]
                if not url.startswith((self.own, "about:", "data:", f"blob:{self.own}")):
                    found.append(f"asked of the network: {url}")
        return found


def must(condition, what):
    if not condition:
        raise AssertionError(what)
    print(f"ok: {what}", flush=True)


@contextmanager
def server(program, arguments):
    process = subprocess.Popen([program, "explore", *arguments], stdout=subprocess.PIPE, text=True)
    try:
        yield process.stdout.readline().strip()
    finally:
        process.terminate()
        process.wait(30)


PATHS = """(async () => {
  const [{ ask }, { linkQuestion }] = await Promise.all([import('/ask.js'), import('/state.js')]);
  return (await ask('/api/file/%s', linkQuestion())).text();
})()"""


def same_as_trace(page, xtask, folder, what):
    """Holds the link and its page against those that the command lines make, bit for bit."""
    is_changed = any(page.state()["houses"].values())
    trace, explain = page.eval(PATHS % "command").splitlines()
    words = shlex.split(trace)
    must(words[:3] == ["cargo", "xtask", "trace"], f"the command line is {trace}")
    if is_changed:
        with open(os.path.join(folder, words[words.index("--map") + 1]), "w", encoding="utf-8") as out:
            out.write(page.eval(PATHS % "map"))
    where = folder if is_changed else None
    printed = subprocess.run([xtask, *words[2:]], cwd=where, capture_output=True, text=True, check=True).stdout
    shown = json.loads(page.eval(PATHS % "paths"))
    must(json.loads(printed) == shown, f"{what}: trace prints the same {len(shown['links'][0]['paths'])} paths")
    shows(page, json.loads(printed)["links"][0], what)
    if shown["links"][0]["paths"]:
        words = shlex.split(explain)
        words[-1] = os.path.join(folder, words[-1])
        subprocess.run([xtask, *words[2:]], cwd=where, capture_output=True, check=True)
        with open(words[-1], encoding="utf-8") as file:
            own = re.sub(r"Map \d+, from", "From", page.eval(PATHS % "explanation"))
            must(file.read() == own, f"{what}: explain makes the same page")


# True if the line over the map tells a link: distance, paths, path loss and delay spread, as far as they are printed.
TELLS = """(() => {
  const text = document.getElementById('summary').textContent, { sight, expected } = %s;
  const numbers = (text.match(/-?[0-9.]+/g) ?? []).map(Number);
  return text.includes(', no line of sight,') !== sight && text.includes('no path') === (expected.length < 3)
    && numbers.length === expected.length && numbers.every((v, i) => Math.abs(v - expected[i]) <= [0.501, 0, 0.0501, 0.501][i]);
})()"""


def shows(page, link, what):
    """Holds the line that the page shows against a link."""
    paths = link["paths"]
    powers = [10 ** (path["gain_db"] / 10) for path in paths]
    expected = [math.dist(link["tx"], link["rx"]), len(paths)]
    if paths:
        mean = sum(p * path["delay_s"] for p, path in zip(powers, paths)) / sum(powers)
        square = sum(p * (path["delay_s"] - mean) ** 2 for p, path in zip(powers, paths)) / sum(powers)
        expected += [-10 * math.log10(sum(powers)), 1e9 * math.sqrt(square)]
    told = {"sight": any(not path["interactions"] for path in paths), "expected": expected}
    page.wait(TELLS % json.dumps(told), 30)
    must(True, f"{what}: the page tells the same: {page.eval('document.getElementById(`summary`).textContent')}")


RINGS = """(async () => {
  const [{ ask }, { cityQuestion }] = await Promise.all([import('/ask.js'), import('/state.js')]);
  return (await (await ask('/api/map', cityQuestion())).json()).rings;
})()"""


def is_indoors(rings, x, y):
    """Even-odd rule."""
    crossings = 0
    for ring in rings:
        for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1]):
            crossings += (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax)
    return crossings % 2 == 1


def is_street(rings, x, y):
    """Outdoors with some room around, so that neither rounding nor a pixel leads indoors."""
    return not any(is_indoors(rings, x + dx, y + dy) for dx in (-1.1, 0, 1.1) for dy in (-1.1, 0, 1.1))


def street(page, near, least=4.0):
    """A place outdoors beside another."""
    rings = page.eval(RINGS)
    steps = [(near[0] + dx, near[1] + dy) for r in range(1, 9) for dx, dy in ((5 * r, r), (-5 * r, r), (r, 5 * r), (r, -5 * r))]
    inside = [p for p in steps if all(5 < v < 250 for v in p) and is_street(rings, *p)]
    # A click beside the receiver takes hold of it.
    rx = page.state()["rx"]
    is_apart = lambda p: near == rx or abs(p[0] - rx[0]) + abs(p[1] - rx[1]) > 18
    return next(p for p in inside if abs(p[0] - near[0]) + abs(p[1] - near[1]) >= least and is_apart(p))


def check_drag(page, xtask, folder):
    for end in ("tx", "rx"):
        before = page.state()[end]
        start, stop = page.screen(before), page.screen(street(page, before))
        page.after(lambda: page.drag(start, (start[0] + 2, start[1] + 1), ((start[0] + stop[0]) / 2, stop[1]), stop))
        after = page.state()[end]
        must(after != before, f"{end} follows the mouse from {before} to {after}")
    start = page.state()["rx"]
    page.eval("document.getElementById('rx').focus()")
    page.after(lambda: page.key("ArrowRight"))
    must(abs(page.state()["rx"][0] - start[0] - 1) < 1e-9, "an arrow key moves a terminal by 1 m")
    same_as_trace(page, xtask, folder, "after dragging")
    for least in (14.0, 20.0, 26.0, 32.0):
        page.after(lambda: page.click(*page.screen(street(page, page.state()["tx"], least))))
        if page.eval("parseInt(document.getElementById('summary').textContent.match(/(\\d+) paths/)[1])") > 0:
            break
    must(page.state()["rx"] != start, "a click on the street puts the receiver there")
    page.wait("document.querySelector('#tables tbody tr')")
    same_as_trace(page, xtask, folder, "near the transmitter")
    choose(page, "heading", 30)
    same_as_trace(page, xtask, folder, "with a turned array")
    choose(page, "heading", 0)


def free_place(page):
    """Puts both terminals where the server proposes: where they were dragged to may lie in a house."""
    page.after(lambda: page.eval("import('/state.js').then(s => { location.hash = '#map=' + s.state.map; })"))
    page.wait("!document.body.classList.contains('is-stale')")


def check_controls(page):
    fragments = set()
    keys = page.eval("[...document.querySelectorAll('#controls [id]')].map(e => e.id)")
    for key in keys:
        count = page.eval("document.querySelectorAll('#effects li').length")
        change = f"""(() => {{
          const input = document.getElementById('{key}');
          if (input.tagName === 'SELECT') input.selectedIndex = (input.selectedIndex + 1) % input.length;
          else input.value = Number(input.value) + ({{ 'set-diffractions': -1, 'set-range': -20 }}['{key}'] ?? Number(input.step) * 4);
          input.dispatchEvent(new Event('input', {{ bubbles: true }}));
        }})()"""
        page.after(lambda: page.eval(change))
        name = page.eval(f"document.getElementById('{key}').closest('label').firstChild.firstChild.textContent.trim()")
        effect = page.eval("document.querySelectorAll('#effects li')[1].textContent")
        must(effect.startswith(name) and "→" in effect and " dB" in effect, f"{name}: its effect is told: {effect}")
        fragments.add(page.eval("location.hash"))
        must(count < 2 or page.eval("document.querySelectorAll('#effects li').length") >= count, f"{name}: earlier effects stay")
    must(len(fragments) == len(keys), "every control is in the address")
    # While the first is compared a second changes: the effect is that of both.
    both = """for (const [key, by] of [['reflections', -1], ['elements', 1]]) {
      const input = document.getElementById(`set-${key}`);
      input.value = Number(input.value) + by;
      input.dispatchEvent(new Event('input', { bubbles: true }));
      await new Promise(done => setTimeout(done, 260));
    }"""
    page.after(lambda: page.eval(f"(async () => {{ {both} }})()"))
    page.wait("[...document.querySelectorAll('#effects li')].slice(1).some(li => li.textContent.startsWith('Elements'))"
              " || document.querySelectorAll('#effects li')[1].textContent.includes(', Elements')", 60)
    told = page.eval("[...document.querySelectorAll('#effects li')].slice(1, 3).map(li => li.textContent)")
    is_told = ", Elements" in told[0] and told[0].startswith("Reflections") or told[0].startswith("Elements") and told[1].startswith("Reflections")
    must(is_told, f"each of two changes in a row is told once: {told}")


def choose(page, key, value):
    """Sets a control as a person does, and waits for what follows."""
    page.after(lambda: page.eval(f"""(() => {{ const input = document.getElementById('set-{key}');
      input.value = '{value}'; input.dispatchEvent(new Event('input', {{ bubbles: true }})); }})()"""))


def check_effects(page, url):
    """A change is told with its own effect too when nothing was compared before it, when a terminal moves behind it, and after a refusal."""
    effects = "[...document.querySelectorAll('#effects li')].slice(1).map(li => li.textContent)"
    change = """(key, value) => { const input = document.getElementById('set-' + key);
      input.value = value; input.dispatchEvent(new Event('input', { bubbles: true })); }"""
    address = url + f"#map={page.state()['map']}"
    page.call("Page.navigate", url="about:blank")
    page.call("Page.navigate", url=address)
    page.wait("window.explorer?.drawn > 0")
    page.eval(f"({change})('reflections', 3)")
    page.wait(f"{effects}.length > 0", 60)
    must(page.eval(effects)[0].startswith("Reflections 2 → 3: error"), f"a change before the first comparison is told: {page.eval(effects)}")
    page.eval(f"({change})('reflections', 1); document.getElementById('rx').dispatchEvent(new KeyboardEvent('keydown', {{ key: 'ArrowRight', bubbles: true }}))")
    page.wait(f"{effects}.length > 1", 60)
    must(page.eval(effects)[0].startswith("Reflections 3 → 1: error"), f"so is one before a terminal moves: {page.eval(effects)}")
    choose(page, "diffractions", 2)
    choose(page, "range", page.eval("document.getElementById('set-range').max"))
    page.eval(f"({change})('diffractions', 3)")
    page.wait("!document.getElementById('fault').hidden")
    choose(page, "range", 30)
    told = page.eval(effects)[0].split(":")[0]
    must("Diffractions 2 → 3" in told and "Dynamic range" in told, f"a refused change is told with the one that makes it work: {told}")


def check_endless(page):
    """Three diffractions without a dynamic range are refused in words, and with one they are shown."""
    choose(page, "diffractions", 2)
    choose(page, "range", 130)
    page.eval("""(() => { const input = document.getElementById('set-diffractions');
      input.value = 3; input.dispatchEvent(new Event('input', { bubbles: true })); })()""")
    page.wait("document.body.classList.contains('is-stale') && document.getElementById('fault').textContent.includes('dynamic range')")
    must(True, f"paths without end are refused: {page.eval('document.getElementById(`fault`).textContent')}")
    choose(page, "range", 30)
    must(not page.eval("document.body.classList.contains('is-stale')"), "a dynamic range brings them back")
    choose(page, "diffractions", 1)
    choose(page, "range", 60)


def check_slopes(page, xtask, folder):
    """Two diffractions in the street of the transmitter: slopes change levels, and the command line has the same."""
    choose(page, "diffractions", 2)
    there = page.eval(PATHS % "paths")
    choose(page, "slopes", "off")
    must("slopes=off" in page.eval("location.hash"), "slopes are in the address")
    must(page.eval(PATHS % "paths") != there, "slopes change the link")
    same_as_trace(page, xtask, folder, "without slopes")
    choose(page, "slopes", "on")
    choose(page, "diffractions", 1)


CURVES = "['aps', 'polar'].map(id => document.querySelectorAll(`#${id} polyline`).length)"
MODEL = """(async () => {
  const [{ ask }, { linkQuestion }] = await Promise.all([import('/ask.js'), import('/state.js')]);
  return (await ask('/api/link', linkQuestion())).json();
})()"""


def show_model(page):
    page.eval("document.getElementById('with-model').click()")
    page.wait("document.getElementById('told-model').textContent.startsWith('CosSim')")


def check_overlays(page):
    """Each switch draws a curve in both spectra, and takes it away; the model's has the scores that the curves have."""
    told = "document.getElementById('told-model').textContent"
    for name in ("other", "reference", "model"):
        is_on = page.eval(f"document.getElementById('with-{name}').checked")
        for flip in (1, 2):
            before = page.eval(CURVES)
            more = 1 if is_on == (flip == 2) else -1
            page.eval(f"document.getElementById('with-{name}').click()")
            page.wait(f"JSON.stringify({CURVES}) === '{json.dumps([n + more for n in before], separators=(',', ':'))}'")
            is_default = flip == 2
            must((f"{name}=" not in page.eval("location.hash")) == is_default, f"curve '{name}' is {'gone again' if flip == 2 else 'switched'}, and in the address")
    show_model(page)
    answer = page.eval(MODEL)
    model, label = answer["model"], answer["spectrum"]["aps_db"]
    with open(os.path.join(os.path.dirname(__file__), "../crates/aps-model/shipped/polar_reg/config.json"), encoding="utf-8") as text:
        statistics = json.load(text)["training_statistics"]
    mean, deviation, top = statistics["mean"], statistics["std"], max(label)
    a, b = ([(10 ** ((db - top) / 10) - mean) / deviation for db in curve] for curve in (label, model["curve"]["aps_db"]))
    cosine = sum(x * y for x, y in zip(a, b)) / (sum(x * x for x in a) * sum(y * y for y in b)) ** 0.5
    must(abs(cosine - model["cosine"]) < 0.02, f"the curves have the CosSim that is told: {cosine:.3f}, {page.eval(told)}")
    must(f"CosSim {model['cosine']:.3f}, MAE {model['mae']:.3f}" in page.eval(told), "the page tells what the server answers")
    curves = page.eval(CURVES)
    choose(page, "heading", 30)
    must("heading 0°" in page.eval(told) and page.eval(CURVES)[0] == curves[0] - 1, f"a turned array has no prediction: {page.eval(told)}")
    choose(page, "heading", 0)
    choose(page, "reflections", 3)
    must("other limits" in page.eval(told), f"other limits have one: {page.eval(told)}")
    choose(page, "reflections", 2)
    address, text = page.eval("location.href"), page.eval(f"{told}.split(';')[0]")
    page.open(address)
    page.wait(f"{told}.startsWith('CosSim')")
    must(page.eval(f"{told}.split(';')[0]") == text, "the address holds the curve")
    page.eval("document.getElementById('with-model').click()")


def check_files(page, folder):
    """Every button gives its file."""
    page.browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=folder)
    page.eval("""(() => { window.saved = []; const make = URL.createObjectURL;
      URL.createObjectURL = blob => { blob.text().then(text => saved.push(text)); return make.call(URL, blob); }; })()""")
    begins = {"map": ("[", "{"), "paths": ("{",), "picture": ("<svg",), "explanation": ("<!DOCTYPE html>",)}
    for i, (name, first) in enumerate(begins.items()):
        page.eval(f"document.querySelector('[data-file={name}]').click()")
        page.wait(f"saved.length > {i}")
        must(page.eval("saved.at(-1)").startswith(first), f"the button of {name} gives its file")
    page.eval("document.querySelector('[data-file=command]').click()")
    page.wait("document.getElementById('command').textContent.startsWith('cargo xtask trace')")
    must(True, "the command line is shown")


def check_maps(page):
    """Another map from the list, if there is one, and back."""
    ids = page.eval("[...document.getElementById('maps').options].map(o => o.value)")
    own = str(page.state()["map"])
    for other in [i for i in ids if i != own][:1] + [own]:
        page.after(lambda: page.eval(f"""(() => {{ const s = document.getElementById('maps');
          s.value = '{other}'; s.dispatchEvent(new Event('change')); }})()"""))
        must(str(page.state()["map"]) == other, f"map {other} of {len(ids)} is shown")


def check_malformed(url):
    """Bodies that no page sends are refused in words, and the server lives on."""
    for body in (b'{"city":', b"\xff\xfe", b"[]", b'{"city":{"map":0},"tx":[NaN,1]}'):
        request = urllib.request.Request(url + "api/link", body, {"Content-Type": "application/json"})
        try:
            urllib.request.urlopen(request, timeout=30)
        except urllib.error.HTTPError as refusal:
            told = json.load(refusal)["error"]
            must(refusal.code == 400 and told["kind"] == "form", f"{body!r} is refused: {told['message']}")
        else:
            must(False, f"{body!r} is refused")


def check_reload(page):
    read = "[document.getElementById('tables').innerText, document.getElementById('summary').textContent]"
    before, address, state = page.eval(read), page.eval("location.href"), page.state()
    page.open(address)
    must(page.state() == state, "the address holds the whole state")
    must(page.eval(read) == before, "the page is the same after a reload")
    page.eval("location.hash = '#map=NaN&tx=1,x&rx=,&reflections=&houses=[1'")
    page.wait("location.hash.includes('rx=') && !document.body.classList.contains('is-stale') && !location.hash.includes('NaN')")
    must(True, "a damaged address leads to the first map")
    page.open(page.own + "#map=999")
    must("there is no map 999" in page.eval("document.getElementById('repairs').textContent"), "a map that is not there is told")
    page.open(address)


# Where the pointer meets the element of that number: its place on the screen and its path; none where it lies under another.
PLACE = """(() => {
  const e = document.querySelectorAll('%s')[%d];
  if (!e) return 'none';
  e.scrollIntoView({ block: 'center' });
  const box = e.getBoundingClientRect();
  let at = { x: box.x + box.width / 2, y: box.y + box.height / 2 };
  if (e.getTotalLength?.() > 0) at = e.getPointAtLength(e.getTotalLength() / 2).matrixTransform(e.getScreenCTM());
  return document.elementFromPoint(at.x, at.y)?.closest('[data-path]') === e ? [at.x, at.y, e.dataset.path] : null;
})()"""


def check_hover(page):
    page.eval("document.querySelector('#tables tbody tr[data-path]').focus()")
    number = page.eval("document.activeElement.dataset.path")
    dimmed = page.eval(f"""[...document.querySelectorAll('svg [data-path]')]
      .every(e => (getComputedStyle(e).opacity < 0.5) === (e.dataset.path !== '{number}'))""")
    must(dimmed, "a row in focus lights up its path and its lobes, and nothing else")
    for kind, name in (("svg path[data-path]", "a path or lobe"), ("#tables tbody tr[data-path]", "a row")):
        met = {}
        for i in range(50):
            place = page.eval(PLACE % (kind, i))
            if place == "none":
                break
            if place:
                x, y, number = place
                page.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y, button="none", buttons=0)
                met[number] = page.eval("""[...new Set([...document.querySelectorAll('svg [data-path]')]
                  .filter(e => getComputedStyle(e).opacity > 0.5).map(e => e.dataset.path))]""")
        must(met and all(lit == [number] for number, lit in met.items()), f"the pointer over {name} lights up what belongs to its path: {met}")
    mirrored = page.eval("document.querySelectorAll('#tables .is-image').length")
    must(mirrored > 0 and page.eval("Boolean(document.getElementById('twin').getAttribute('d'))"), f"mirror lobes are marked: {mirrored}")


def covered(page, url):
    """Parts of the map for which the server has a value of each quantity that one trace gives."""
    question, (low, high) = page.eval("""(async () => {
      const [{ ask }, s] = await Promise.all([import('/ask.js'), import('/state.js')]);
      const city = s.cityQuestion();
      return [{ city, tx: s.state.tx, ...s.settingsQuestion(), show: 'link' }, (await (await ask('/api/map', city)).json()).area];
    })()""")
    question["cell_m"] = max(b - a for a, b in zip(low, high)) / 128
    request = urllib.request.Request(url + "api/coverage", json.dumps(question).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request, timeout=600) as answer:
        grid, *blocks = (json.loads(line) for line in answer)
    names = {"level": "level_db", "paths": "paths", "sight": "sight", "direction": "direction_deg"}
    return {show: sum(v is not None for block in blocks for v in block[name]) / grid["of"] for show, name in names.items()}


def check_coverage(page, url):
    parts = covered(page, url)
    for show in page.eval("[...document.getElementById('show').options].map(o => o.value).filter(Boolean)"):
        page.eval(f"""(() => {{ const s = document.getElementById('show'); s.value = '{show}'; s.dispatchEvent(new Event('change')); }})()""")
        page.wait("!document.getElementById('progress').hidden")
        page.wait("document.getElementById('progress').hidden && !document.getElementById('legend').hidden", 1800)
        painted = page.eval("""(() => { const c = document.getElementById('heat');
          const copy = new OffscreenCanvas(c.width, c.height).getContext('2d', { willReadFrequently: true });
          copy.drawImage(c, 0, 0);
          const d = copy.getImageData(0, 0, c.width, c.height).data;
          return d.filter((v, i) => i % 4 === 3 && v > 0).length / (d.length / 4); })()""")
        # The reference limits reach what others reach, and more.
        is_whole = painted >= parts["level"] if show == "error" else abs(painted - parts[show]) < 1e-9
        must(painted > 0.05 and is_whole, f"coverage '{show}' fills the {100 * painted:.0f} % of the map that have a value")
    # A terminal that moves ends what runs.
    page.eval("(() => { const s = document.getElementById('show'); s.value = 'error'; s.dispatchEvent(new Event('change')); })()")
    page.wait("!document.getElementById('progress').hidden")
    start = page.screen(page.state()["tx"])
    stop = page.screen(street(page, page.state()["tx"]))
    page.mouse("mousePressed", *start)
    page.call("Input.dispatchMouseEvent", type="mouseMoved", x=stop[0], y=stop[1], button="left", buttons=1)
    page.wait("document.getElementById('progress').hidden")
    page.mouse("mouseReleased", *stop)
    page.wait("!document.getElementById('progress').hidden")
    must(True, "coverage ends when a terminal moves, and begins again when it rests")
    page.eval("(() => { const s = document.getElementById('show'); s.value = 'level'; s.dispatchEvent(new Event('change')); })()")
    page.wait("document.getElementById('progress').hidden", 300)
    place = page.state()["rx"]
    page.after(lambda: page.click(*page.screen(street(page, page.state()["tx"], 14.0))))
    must(page.state()["rx"] != place, f"a cell that is clicked becomes the receiver: {page.state()['rx']}")
    page.eval("(() => { const s = document.getElementById('show'); s.value = ''; s.dispatchEvent(new Event('change')); })()")


def choose_mode(page, mode):
    page.eval(f"document.querySelector('input[name=mode][value={mode}]').click()")


def check_houses(page, xtask, folder):
    walls = lambda: int(page.eval("document.getElementById('repairs').textContent.match(/^(\\d+) walls/)[1]"))
    before, rx = walls(), page.state()["rx"]
    choose_mode(page, "draw")
    corners = [(rx[0] + dx, rx[1] + dy) for dx, dy in ((3, 3), (9, 3), (9, 8), (3, 8))]
    for corner in corners:
        page.click(*page.screen(corner))
    page.after(lambda: page.key("Enter"))
    drawn = page.state()["houses"]["drawn"]
    must(len(drawn) == 1 and len(drawn[0]) == 4, f"a house is drawn: {drawn}")
    must(walls() != before, f"it is in the map: {before} walls, then {walls()}")
    same_as_trace(page, xtask, folder, "with a drawn house")
    choose_mode(page, "houses")
    house = page.eval("document.querySelector('#houses path:last-child').dataset.house")
    page.eval(f"document.querySelector('[data-house=\"{house}\"]').focus()")
    page.after(lambda: page.key("ArrowUp"))
    must(page.state()["houses"]["drawn"][0][0][1] == drawn[0][0][1] + 1, "an arrow key moves it")
    at = page.screen([corners[0][0] + 3, corners[0][1] + 3.5])
    page.after(lambda: page.drag(at, (at[0] + 4, at[1]), (at[0] + 9, at[1] + 2)))
    must(page.state()["houses"]["drawn"][0][0][0] > drawn[0][0][0], "the mouse moves it")
    address, text = page.eval("location.href"), page.eval("document.getElementById('repairs').textContent")
    page.open(address)
    must(page.eval("document.getElementById('repairs').textContent") == text, "the address holds the house")
    choose_mode(page, "houses")
    page.eval("document.querySelector('#houses path').focus()")
    page.after(lambda: page.eval("document.getElementById('remove').click()"))
    must(len(page.state()["houses"]["gone"]) == 1, "a house is taken away")
    page.after(lambda: page.key("z", modifiers=2))
    must(page.state()["houses"]["gone"] == [], "and called back")
    page.after(lambda: page.eval("document.getElementById('reset').click()"))
    must(walls() == before, "the houses are as they were read")
    choose_mode(page, "link")


def check_house_by_keys(page, xtask, folder):
    x, y = page.eval("import('/state.js').then(s => s.state.rx.map(Math.round))")
    choose_mode(page, "draw")
    page.eval("document.querySelector('input[name=mode]:checked').focus()")
    for _ in range(5):
        if page.eval("document.activeElement.id") != "cross":
            page.key("Tab", code="Tab", windowsVirtualKeyCode=9)
    must(page.eval("document.activeElement.id") == "cross", "Tab leads to the cross that draws")
    for key, steps in (("ArrowRight", 3), ("ArrowUp", 3), (" ", 1), ("ArrowRight", 6), (" ", 1), ("ArrowUp", 5), (" ", 1)):
        for _ in range(steps):
            page.key(key)
    page.key("Escape")
    must(not page.eval("document.getElementById('drawing').getAttribute('d')"), "Escape drops what is drawn")
    for key, steps in ((" ", 1), ("ArrowLeft", 6), (" ", 1), ("ArrowDown", 5), (" ", 1)):
        for _ in range(steps):
            page.key(key)
    page.after(lambda: page.key("Enter"))
    drawn = page.state()["houses"]["drawn"]
    must(drawn == [[[x + 9, y + 8], [x + 3, y + 8], [x + 3, y + 3]]], f"a house is drawn by keys beside ({x}, {y}): {drawn}")
    same_as_trace(page, xtask, folder, "with a house drawn by keys")
    page.after(lambda: page.eval("document.getElementById('reset').click()"))
    choose_mode(page, "link")


def check_house_with_faults(page):
    """A ring that crosses itself is repaired, and the repair is told."""
    rx = page.state()["rx"]
    choose_mode(page, "draw")
    for dx, dy in ((3, 3), (11, 9), (3, 9), (11, 3)):
        page.click(*page.screen([rx[0] + dx, rx[1] + dy]))
    page.after(lambda: page.eval("document.getElementById('finish').click()"))
    told = page.eval("document.getElementById('repairs').textContent")
    must("self-intersection" in told, f"repairs are told: {told}")
    page.after(lambda: page.eval("document.getElementById('reset').click()"))
    choose_mode(page, "link")


def check_inside(page):
    """A terminal in a house is told, and nothing is written to the console."""
    rings = page.eval(RINGS)
    indoors = next([x + 0.3, y + 0.3] for x in range(9, 250) for y in range(9, 250) if is_indoors(rings, x + 0.3, y + 0.3))
    page.eval(f"import('/state.js').then(s => {{ s.state.rx = {indoors}; location.hash = s.toFragment(); }})")
    page.wait("document.body.classList.contains('is-stale') && !document.getElementById('fault').hidden")
    must("inside building" in page.eval("document.getElementById('fault').textContent"), "a receiver in a house is told")
    page.eval("import('/state.js').then(s => { location.hash = '#map=' + s.state.map; })")
    page.wait("!document.body.classList.contains('is-stale')")


def check_two_tabs(browser, url, page):
    other = Page(browser, url)
    tabs = [(p, p.screen(p.state()["rx"]), p.screen(street(p, p.state()["rx"], least))) for p, least in ((page, 4.0), (other, 12.0))]
    for p, start, _ in tabs:
        p.mouse("mousePressed", *start)
    for step in range(12):
        for p, start, stop in tabs:
            at = [a + step / 11 * (b - a) for a, b in zip(start, stop)]
            p.call("Input.dispatchMouseEvent", type="mouseMoved", x=at[0], y=at[1], button="left", buttons=1)
    for p, _, stop in tabs:
        p.after(lambda: p.mouse("mouseReleased", *stop))
    for p in (page, other):
        shown = json.loads(p.eval(PATHS % "paths"))["links"][0]
        must(shown["rx"] == p.state()["rx"], "each of two tabs shows its own link")
    # A tab behind another draws no frames.
    page.call("Page.bringToFront")
    return other


def check_touch(page):
    page.call("Emulation.setTouchEmulationEnabled", enabled=True)
    page.picture(None, width=390, height=800)
    before = page.state()["rx"]
    x, y = page.screen(before)
    far = page.screen(street(page, before))

    def swipe():
        page.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{"x": x + 6, "y": y + 4}])
        for part in (0.3, 0.6, 1):
            points = [{"x": x + 6 + part * (far[0] - x), "y": y + 4 + part * (far[1] - y)}]
            page.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=points)
        page.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    page.after(swipe)
    must(page.state()["rx"] != before, f"a finger beside the terminal takes it along: {before} to {page.state()['rx']}")
    page.call("Emulation.setTouchEmulationEnabled", enabled=False)
    free_place(page)


def check_widths(page):
    """With the longest texts: the scores of the model and the command line."""
    show_model(page)
    page.eval("document.querySelector('[data-file=command]').click()")
    page.wait("document.getElementById('command').textContent.includes('xtask')")
    for width in WIDTHS:
        page.picture(None, width=width)
        found = page.eval(OVERFLOW)
        must(not found, f"nothing is wider than {width} px {found}")
    page.picture(None)
    page.eval("document.getElementById('with-model').click()")


def frames(page, end="rx", seconds=6):
    """Frames a second with new paths while a terminal is dragged across the map."""
    start = page.screen(page.state()[end])
    box = page.eval("(() => { const b = document.getElementById('map').getBoundingClientRect(); return [b.left + 8, b.top + 8, b.right - 8, b.bottom - 8]; })()")
    page.mouse("mousePressed", *start)
    got = page.eval(DRAG % json.dumps([end, *box, seconds]))
    page.mouse("mouseReleased", *start)
    free_place(page)
    return got


def pictures_of(page, folder):
    os.makedirs(folder, exist_ok=True)
    for dark in (False, True):
        for name, width, height in (("desk", 1280, 900), ("wide", 1680, 1000), ("phone", 390, 844)):
            page.picture(os.path.join(folder, f"{name}-{'dark' if dark else 'light'}.png"), dark, width, height, 2 if width < 700 else 1)
    page.picture(None)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("explore")
    parser.add_argument("xtask")
    parser.add_argument("--maps", default="tests/data/helsinki.geojson")
    parser.add_argument("--map", help="number of the map [default: the first]")
    parser.add_argument("--pictures")
    parser.add_argument("--only-frames", action="store_true", help="drag, and check nothing but the frames")
    args = parser.parse_args()
    args.xtask = os.path.abspath(args.xtask)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder, server(args.explore, ["--maps", args.maps]) as url:
        must(re.fullmatch(r"http://127\.0\.0\.1:\d+/", url), f"the page is at {url}")
        browser = Browser(folder)
        page = Page(browser, url + (f"#map={args.map}" if args.map else ""))
        pages = [page]
        if not args.only_frames:
            check_drag(page, args.xtask, folder)
            check_controls(page)
            check_reload(page)
            check_malformed(url)
            page.open(url + f"#map={page.state()['map']}")
            check_hover(page)
            check_slopes(page, args.xtask, folder)
            check_endless(page)
            check_effects(page, url)
            page.open(url + f"#map={page.state()['map']}")
            check_overlays(page)
            check_files(page, folder)
            check_maps(page)
            check_houses(page, args.xtask, folder)
            check_house_by_keys(page, args.xtask, folder)
            check_house_with_faults(page)
            check_inside(page)
            check_coverage(page, url)
            pages.append(check_two_tabs(browser, url, page))
            check_widths(page)
            check_touch(page)
            page.open(url + f"#map={page.state()['map']}")
        if args.pictures:
            pictures_of(page, args.pictures)
        for end, what in (("rx", "the receiver"), ("tx", "the transmitter"), ("rx", "the receiver with the model's prediction")):
            if "model" in what:
                show_model(page)
            got = frames(page, end)
            rate, shown = got["drawn"] / got["seconds"], got["frames"] / got["seconds"]
            told = f"{rate:.1f} frames a second follow {what} ({shown:.1f} shown), the longest took {got['longest']:.0f} ms"
            must(rate >= LEAST_FRAMES, told)
        for p in pages:
            found = p.faults()
            must(not found, f"nothing in the console, nothing asked of others {found}")
        browser.close()


if __name__ == "__main__":
    try:
        main()
    except AssertionError as failure:
        sys.exit(f"FAILED: {failure}")
