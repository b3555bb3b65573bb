"""Footprints and links of several tests, in a module that processes of any start can import."""

import json
import tempfile
from pathlib import Path

import numpy as np

import map2aps

HOUSE = np.array([(40.0, 40.0), (60.0, 40.0), (60.0, 60.0), (40.0, 60.0)])
HELSINKI = Path(__file__).parents[1] / "data" / "helsinki.geojson"


def geojson(file: Path, *rings: np.ndarray, **tags: str) -> Path:
    """Writes a city of polygons with the same tags."""
    closed = [[*ring.tolist(), ring[0].tolist()] for ring in rings]
    shapes = [{"type": "Polygon", "coordinates": [ring]} for ring in closed]
    features = [{"type": "Feature", "properties": tags, "geometry": shape} for shape in shapes]
    file.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return file


def answers(seed: int) -> list[np.ndarray]:
    """Something of every part of the package."""
    scene = map2aps.Scene.synthetic(seed)
    grid = np.stack(np.meshgrid(np.arange(1.0, 256.0, 16.0), np.arange(1.0, 256.0, 16.0)), -1).reshape(-1, 2)
    is_outdoor = scene.is_outdoor(grid)
    rx = grid[is_outdoor]
    paths = map2aps.Tracer(scene).trace(rx[0], rx[5:9])
    spectra = map2aps.label(paths).aps_db
    power = np.nan_to_num(10.0 ** (spectra / 10.0))
    scored = map2aps.metrics(power, power[::-1])
    found = [is_outdoor, scene.raster(64), paths.gain, spectra, map2aps.pdp(paths).pdp_db, scored["mae"]]
    found.append(map2aps.PolarView(scene).ways(rx[0], rx[5:7]))
    with tempfile.TemporaryDirectory() as folder:
        made = map2aps.make_dataset(folder, 1, tx_per_map=2, rx_per_map=6, seed=seed, progress=None)
        assert made.links > 0
        found += [np.array(made[0]["aps_db"]), np.array(made[0]["rx"])]
    return found
