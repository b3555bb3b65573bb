"""Footprints and links of several tests, in a module that processes of any start can import."""

import numpy as np

import map2aps

HOUSE = np.array([(40.0, 40.0), (60.0, 40.0), (60.0, 60.0), (40.0, 60.0)])


def gains(seed: int) -> np.ndarray:
    scene = map2aps.Scene.synthetic(seed)
    grid = np.stack(np.meshgrid(np.arange(1.0, 256.0, 16.0), np.arange(1.0, 256.0, 16.0)), -1).reshape(-1, 2)
    rx = grid[scene.is_outdoor(grid)]
    return map2aps.Tracer(scene).trace(rx[0], rx[5:]).gain
