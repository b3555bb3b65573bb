"""Golden values for the local plane: plane.csv beside this script.

Transverse Mercator on WGS84 about an origin of its own, by PROJ's exact algorithm (pyproj 3.7). The output is the same
each time.
"""

import random
from pathlib import Path

from pyproj import CRS, Transformer

rng = random.Random(2026)
lines = ["origin_lon,origin_lat,lon,lat,x,y"]
for lat0 in (-75, -45, -1, 0, 12.5, 35, 48.1, 60.17, 70, 78):
    lon0 = round(rng.uniform(-180, 180), 6)
    plane = CRS.from_proj4(f"+proj=tmerc +algo=poder_engsager +lat_0={lat0} +lon_0={lon0} +k=1 +ellps=WGS84 +units=m")
    to_plane = Transformer.from_crs(CRS.from_proj4("+proj=longlat +ellps=WGS84"), plane, always_xy=True)
    for reach in (0.01, 0.1, 0.5, 2):
        for _ in range(5):
            lon = round(lon0 + rng.uniform(-reach, reach), 7)
            lat = round(lat0 + rng.uniform(-reach, reach), 7)
            x, y = to_plane.transform(lon, lat)
            lines.append(f"{lon0},{lat0},{lon},{lat},{x:.6f},{y:.6f}")
Path(__file__).with_suffix(".csv").write_text("\n".join(lines) + "\n")
