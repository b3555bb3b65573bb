"""Golden values for projected coordinates: projected.csv beside this script.

Longitude and latitude of points in UTM and Web Mercator, by PROJ (pyproj 3.7). The output is the same each time.
"""

import random
from pathlib import Path

from pyproj import Transformer

rng = random.Random(2026)
lines = ["epsg,x,y,longitude_deg,latitude_deg"]


def add(code, x, y, datum):
    longitude, latitude = Transformer.from_crs(code, datum, always_xy=True).transform(x, y)
    lines.append(f"{code},{x},{y},{longitude:.13f},{latitude:.13f}")


for code in (32601, 32633, 32735, 32760, 25828, 25832, 25838):
    for reach in (1_000, 350_000, 1_000_000):
        for _ in range(8):
            x = round(500_000 + rng.uniform(-reach, reach), 3)
            add(code, x, round(rng.uniform(1e5, 8.5e6), 3), 4258 if code < 30_000 else 4326)
for _ in range(40):
    add(3857, round(rng.uniform(-2e7, 2e7), 3), round(rng.uniform(-1.5e7, 1.5e7), 3), 4326)
Path(__file__).with_suffix(".csv").write_text("\n".join(lines) + "\n")
