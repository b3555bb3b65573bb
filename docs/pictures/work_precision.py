"""Draws work-precision.svg: error of the label against time a link, before the search by bounds and now.

    python3 work_precision.py work-precision-before.csv work-precision-now.csv work-precision.svg

Each file has the means over maps and runs of `tracer-settings.csv` of `cargo xtask report --study tracer`, on the same maps and machine; the
first is of the last version whose tracer computed every pair of waves at a corner. The file of a report itself can be given too.
"""

import csv
import math
import sys
from collections import defaultdict

INK, GREY, RED, BLUE = "#222", "#bbb", "#c1121f", "#0353a4"
LEFT, TOP, WIDTH, HEIGHT = 70, 20, 800, 400
TIMES_US, ERRORS_DB = (0.7, 10_000.0), (0.5, 50.0)
# Settings that are named: the name, and where it lies from the point (right and down, anchor).
ABOVE, BELOW, LEFT_OF = (6, -7, "start"), (-6, 16, "end"), (-2, -9, "end")
BEFORE = {
    "R2 D1": ("R2 D1", ABOVE),
    "R2 D1, 30 dB": ("R2 D1, 30 dB", (2, 17, "start")),
    "R5 D2": ("R5 D2", LEFT_OF),
    "R5 D2, 20 dB": ("R5 D2, 20 dB", ABOVE),
    "R5 D2, 30 dB": ("30 dB", ABOVE),
}
NOW = {
    "R2 D1": ("R2 D1", (6, 17, "middle")),
    "R2 D1, 30 dB": ("R2 D1, 30 dB", BELOW),
    "R3 D1": ("R3 D1", (-8, 5, "end")),
    "R5 D2, 10 dB": ("R5 D2, 10 dB", BELOW),
    "R5 D2, 20 dB": ("20 dB", BELOW),
    "R5 D2, 30 dB": ("30 dB", BELOW),
    "R5 D2": ("R5 D2", (8, 14, "start")),
}


def settings(path):
    """Time a link and mean error of each setting, over all maps."""
    rows = defaultdict(list)
    with open(path) as file:
        for row in csv.DictReader(file):
            rows[row["setting"]].append((float(row["total_us"]), float(row["mean_error_db"])))
    return {name: tuple(sum(column) / len(column) for column in zip(*of)) for name, of in rows.items()}


def front(points):
    """The points that no other beats in both, by time; errors within a hundredth of each other are equal."""
    best, found = math.inf, []
    for time, error in sorted(points):
        if error < 0.99 * best:
            best = error
            found.append((time, error))
    return found


def x(time):
    first, last = map(math.log, TIMES_US)
    return LEFT + WIDTH * (math.log(time) - first) / (last - first)


def y(error):
    first, last = map(math.log, ERRORS_DB)
    return TOP + HEIGHT * (last - math.log(error)) / (last - first)


def text(at_x, at_y, words, anchor="middle", colour=INK, size=13):
    return f'<text x="{at_x:.1f}" y="{at_y:.1f}" text-anchor="{anchor}" fill="{colour}" font-size="{size}">{words}</text>'


def series(all_settings, colour, named):
    """Points, front and names of one version."""
    on_front = front(all_settings.values())
    steps = [f"{x(on_front[0][0]):.1f},{y(on_front[0][1]):.1f}"]
    for (_, before), (time, error) in zip(on_front, on_front[1:]):
        steps += [f"{x(time):.1f},{y(before):.1f}", f"{x(time):.1f},{y(error):.1f}"]
    yield f'<polyline points="{" ".join(steps)}" fill="none" stroke="{colour}" stroke-width="1.5"/>'
    for name, (time, error) in all_settings.items():
        fill = colour if (time, error) in on_front else "white"
        yield f'<circle cx="{x(time):.1f}" cy="{y(error):.1f}" r="4" fill="{fill}" stroke="{colour}"><title>{name}: {time:.1f} us, {error:.3g} dB</title></circle>'
        if name in named:
            words, (right, down, anchor) = named[name]
            yield text(x(time) + right, y(error) + down, words, anchor, colour, 11)


def main(before, now, target):
    out = [
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 900 470" font-family="sans-serif">',
        '<rect width="900" height="470" fill="white"/>',
        f'<rect x="{LEFT}" y="{TOP}" width="{WIDTH}" height="{HEIGHT}" fill="#fafafa" stroke="{INK}"/>',
        text(LEFT + WIDTH / 2, 462, "time a link, label included [us]"),
        f'<text transform="translate(18 220) rotate(-90)" text-anchor="middle" fill="{INK}" font-size="13">mean error of the label [dB]</text>',
    ]
    for time in (1, 10, 100, 1000, 10_000):
        out.append(f'<line x1="{x(time):.1f}" y1="{TOP}" x2="{x(time):.1f}" y2="{TOP + HEIGHT}" stroke="{GREY}" stroke-dasharray="2 3"/>')
        out.append(text(x(time), TOP + HEIGHT + 20, f"{time:,}"))
    for error in (0.5, 1, 2, 5, 10, 20, 50):
        out.append(f'<line x1="{LEFT}" y1="{y(error):.1f}" x2="{LEFT + WIDTH}" y2="{y(error):.1f}" stroke="{GREY}" stroke-dasharray="2 3"/>')
        out.append(text(LEFT - 8, y(error) + 4, f"{error:g}", "end"))
    out += series(settings(before), RED, BEFORE)
    out += series(settings(now), BLUE, NOW)
    for at_y, colour, words in ((TOP + 24, RED, "before the search by bounds"), (TOP + 46, BLUE, "now")):
        out.append(f'<circle cx="{LEFT + WIDTH - 212}" cy="{at_y - 4}" r="4" fill="{colour}"/>')
        out.append(text(LEFT + WIDTH - 200, at_y, words, "start", colour))
    out.append("</svg>\n")
    with open(target, "w") as file:
        file.write("\n".join(out))


if __name__ == "__main__":
    main(*sys.argv[1:])
