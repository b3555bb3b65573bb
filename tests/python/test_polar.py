import json
from pathlib import Path

import numpy as np
import pytest

import map2aps
from shapes import HOUSE

FEATURES = 14


def test_every_way_is_that_of_the_script_that_tries_all_walls() -> None:
    golden = json.loads((Path(__file__).parents[1] / "golden" / "polar.json").read_text())
    view = map2aps.PolarView(map2aps.Scene.from_polygons(golden["city"]))
    for link in golden["links"]:
        found = view.ways(link["tx"], link["rx"])
        assert found.dtype == np.float32 and found.shape[::2] == (1, FEATURES + 2)
        rows = [
            [*features, row["direction"], kind * 3 + bounces]
            for row in link["rows"]
            for kind, bounces, features in sorted(row["ways"], key=lambda way: way[:2])
        ]
        # Of every other ray.
        found = found[0][found[0, :, FEATURES] % 2 == 0]
        assert found.shape == (len(rows), FEATURES + 2) and len(rows) > 40
        assert np.abs(found - np.array(rows)).max() < 1e-5


def test_links_of_many_ends_are_those_of_each_pair(scene: map2aps.Scene, outdoors: np.ndarray) -> None:
    view = map2aps.PolarView(scene)
    tx, rx = outdoors[:2], outdoors[10:14]
    links = view.ways(tx, rx)
    assert links.shape[::2] == (8, 16) and np.isfinite(links).all()
    pairs = [view.ways(t, r)[0] for t in tx for r in rx]
    assert max(map(len, pairs)) == links.shape[1]
    for link, alone in zip(links, pairs):
        assert np.array_equal(link[: len(alone)], alone) and not link[len(alone) :].any() and (alone[:, 1] == 1).all()
    for same in [rx.astype(np.float32), np.repeat(rx, 2, axis=0)[::2], np.asfortranarray(rx), rx.tolist()]:
        assert np.array_equal(view.ways(tx, same), links)
    for ends in ((tx, np.zeros((0, 2))), (np.zeros((0, 2)), rx), (np.zeros((0, 2)), np.zeros((0, 2)))):
        assert view.ways(*ends).shape == (0, 1, 16)
    assert view.scene is scene


def test_ends_that_cannot_stand_where_they_are_are_named(scene: map2aps.Scene) -> None:
    view, out = map2aps.PolarView(map2aps.Scene.from_polygons([HOUSE])), (10.0, 10.0)
    for tx, rx, told in [
        (out, [(1.0, 1.0), (50.0, 50.0)], "link 1: .*inside building 0"),
        (out, np.vstack([np.full((300, 2), 1.0), [(50.0, 50.0)]]), "link 300: .*inside building 0"),
        ((np.nan, 1.0), out, "link 0: .*finite"),
        (out, [1.0, 2.0, 3.0], r"rx: .*float64 of shape \(3,\)"),
        (np.zeros((1, 2), complex), out, r"tx: .*complex128 of shape \(1, 2\)"),
    ]:
        with pytest.raises(ValueError, match=told):
            view.ways(tx, rx)
    with pytest.raises(TypeError, match="Scene"):
        map2aps.PolarView([HOUSE])
    with pytest.raises(MemoryError, match="rx: links: 121000000 of"):
        view.ways(np.full((11_000, 2), 1.0), np.full((11_000, 2), 2.0))
