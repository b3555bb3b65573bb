"""Scenes and their fields: what the tracer is measured against.

Lengths in wavelengths. Receivers stand half a wavelength apart on lines, so that 16 in a row are an array, and on a grid; none is
nearer to a wall than 0.4. Walls are perfect conductors or have the admittance sqrt(eps - 1/2) for concrete at 3.5 GHz, eps = 5.24 -
0.6322 j (ITU-R P.2040-3): between what Fresnel's coefficient asks for head-on, sqrt(eps), and grazing, sqrt(eps - 1). Fields are
scaled so that without bodies e^{-j k r} / sqrt(r) is what is left far away.

Writes NAME.json beside this file, 7 decimals: polygons, sources, receivers, admittance, and by material and source re, im, re, im ... of
the receivers in order. Takes some minutes, and for the largest scene 2 GB. With names as arguments only those scenes.

    python3 tests/golden/fullwave/scenes.py
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

from solver import Bodies, Solution, is_inside, wall_distance

K = 2 * np.pi
ADMITTANCE = np.sqrt(5.24 - 0.6322j - 0.5)
CLEAR = 0.4


def box(x0, x1, y0, y1):
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


def along_x(y, first, last):
    return [(x, y) for x in np.arange(first, last + 1e-9, 0.5)]


def along_y(x, first, last):
    return [(x, y) for y in np.arange(first, last + 1e-9, 0.5)]


def grid(x0, x1, y0, y1, columns, rows):
    return [(x, y) for x in np.linspace(x0, x1, columns) for y in np.linspace(y0, y1, rows)]


def block(a):
    """One house, its longer walls a wavelengths."""
    return {
        "polygons": [box(0, a, 0, 0.6 * a)],
        "sources": [(-0.45 * a, -0.37 * a)],
        "receivers": along_x(0.86 * a, -0.6 * a, 1.7 * a)
        + along_y(1.21 * a, -0.5 * a, 1.2 * a)
        + grid(-0.55 * a, 1.6 * a, -0.5 * a, 1.25 * a, 11, 9),
    }


def terrace():
    """Six flush houses, each a little before or behind its neighbours: one ring."""
    widths, fronts, depth = [5.5, 6, 5, 6.5, 5, 6], [0, 0.8, -0.3, 0.6, 0, 0.9], 9
    x, front, back = 0, [], []
    for width, y in zip(widths, fronts):
        front += [(x, y), (x + width, y)]
        back += [(x, y + depth), (x + width, y + depth)]
        x += width
    return {
        "polygons": [front + back[::-1]],
        "sources": [(-7.3, -5.2), (12.4, -6.1)],
        "receivers": along_x(-2.3, -8, 42)
        + along_x(13.1, -4, 38)
        + along_y(37.7, -8, 20)
        + grid(-8, 44, -8.5, 18, 12, 7),
    }


SCENES = {
    "block05": lambda: block(5),
    "block10": lambda: block(10),
    "block20": lambda: block(20),
    "block40": lambda: block(40),
    "canyon": lambda: {
        "polygons": [
            box(0, 18, -9, 0),
            box(20, 38, -8.5, 0),
            box(1, 17, 6, 15),
            box(19.5, 37, 6.3, 14),
        ],
        "sources": [(4.3, 2.1), (-8.2, -6.4)],
        "receivers": along_x(3.9, -6, 44)
        + along_x(-12.2, -4, 42)
        + along_y(41.3, -14, 18)
        + along_y(18.9, -12, 18)
        + grid(-6, 44, -13, 18.5, 12, 8),
    },
    "behind": lambda: {
        "polygons": [box(0, 16, 0, 8), box(3, 18, 12.5, 20)],
        "sources": [(7.3, -9.1), (-6.2, 3.3)],
        "receivers": along_x(10.2, -6, 24)
        + along_x(24.3, -6, 28)
        + along_y(20.6, -6, 26)
        + grid(-7, 26, -4, 28, 11, 9),
    },
    "courtyard": lambda: {
        "polygons": [
            [
                (0, 0), (12, 0), (12, 5), (5, 5), (5, 17), (21, 17),
                (21, 5), (15, 5), (15, 0), (26, 0), (26, 22), (0, 22),
            ]
        ],
        "sources": [(9.1, -8.2), (8.2, 14.3)],
        "receivers": along_x(8.3, 5.5, 20.5)
        + along_x(13.1, 5.5, 20.5)
        + along_x(-4.2, -6, 32)
        + along_x(26.4, -4, 30)
        + grid(-6, 32, -9, 27, 12, 11),
    },
    "terrace": terrace,
    "needle": lambda: {
        "polygons": [[(0, 0), (24, -1), (24, 1)], box(30, 38, -7, 5)],
        "sources": [(5.2, -9.3), (-9.4, -1.2)],
        "receivers": along_x(6.2, -8, 44)
        + along_y(27.2, -12, 12)
        + along_x(9.8, -8, 44)
        + grid(-8, 44, -12, 12, 12, 8),
    },
    "town": lambda: {
        "polygons": [
            box(0, 9, 0, 7),
            box(13, 22, 1, 8),
            [(27, -1), (35, 1), (33.5, 8), (25.5, 6)],
            box(1, 8, 11, 20),
            [(12, 12), (20, 12), (20, 16), (16, 16), (16, 21), (12, 21)],
            box(25, 36, 12, 18),
            box(2, 12, 24.5, 31),
            box(17, 30, 25, 32),
        ],
        "sources": [(10.8, -4.2), (23.6, 9.7)],
        "receivers": along_x(9.6, -4, 40)
        + along_x(22.7, -4, 40)
        + along_y(10.7, -5, 35)
        + along_y(23.3, -5, 35)
        + grid(-4, 40, -5, 35, 13, 11),
    },
}


def write(name):
    scene, began = SCENES[name](), time.time()
    polygons = [np.array([complex(*p) for p in ring]) for ring in scene["polygons"]]
    is_clear = lambda p: all(
        not is_inside(ring, p) and wall_distance(ring, p) >= CLEAR for ring in polygons
    )
    receivers = [p for p in scene["receivers"] if is_clear(complex(*p))]
    sources = [complex(*p) for p in scene["sources"]]
    assert all(is_clear(s) for s in sources)
    x = np.array([complex(*p) for p in receivers])
    out = {
        "polygons": scene["polygons"],
        "sources": scene["sources"],
        "receivers": [[round(float(v), 4) for v in p] for p in receivers],
        "admittance": [round(ADMITTANCE.real, 12), round(ADMITTANCE.imag, 12)],
    }
    bodies = Bodies(polygons)
    for material, eta in [("perfect_conductor", None), ("impedance", ADMITTANCE)]:
        u = Solution(bodies, K, sources, eta).field(np.round(x.real, 4) + 1j * np.round(x.imag, 4))
        u = u * np.sqrt(np.pi * K / 2) * np.exp(-0.25j * np.pi)
        flat = np.stack((u.T.real, u.T.imag), axis=-1).reshape(len(sources), -1)
        out[material] = [[round(float(v), 7) for v in of_source] for of_source in flat]
    line = lambda item: ":".join(json.dumps(part, separators=(",", ":")) for part in item)
    text = "{\n" + ",\n".join(map(line, out.items())) + "\n}\n"
    (Path(__file__).parent / f"{name}.json").write_text(text)
    print(f"{name}: {len(bodies.x)} nodes, {len(x)} receivers, {time.time() - began:.0f} s", flush=True)


if __name__ == "__main__":
    for name in sys.argv[1:] or SCENES:
        write(name)
