"""A made-up city, its paths, and a small data set, for all tests."""

from pathlib import Path

import numpy as np
import pytest

import map2aps


@pytest.fixture(scope="session")
def scene() -> map2aps.Scene:
    return map2aps.Scene.synthetic(seed=3)


@pytest.fixture(scope="session")
def outdoors(scene: map2aps.Scene) -> np.ndarray:
    """Points of a grid that are outdoors."""
    grid = np.stack(np.meshgrid(np.arange(1.0, 256.0, 8.0), np.arange(1.0, 256.0, 8.0)), -1).reshape(-1, 2)
    return grid[scene.is_outdoor(grid)]


@pytest.fixture(scope="session")
def paths(scene: map2aps.Scene, outdoors: np.ndarray) -> map2aps.Paths:
    return map2aps.Tracer(scene).trace(outdoors[:2], outdoors[10:60])


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("data") / "set"
    map2aps.make_dataset(
        folder, 6, tx_per_map=2, rx_per_map=6, store_paths=True, store_pdp=True, protocol="released", progress=None
    )
    return folder
