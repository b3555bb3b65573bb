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
    ways = 0
    for link in golden["links"]:
        found = view.input(link["tx"], link["rx"])
        assert found.dtype == np.float32 and found.shape == (1, 180, 15 * FEATURES)
        for row in link["rows"]:
            expected = np.zeros(15 * FEATURES)
            for kind, bounces, features in row["ways"]:
                first = (kind * 3 + bounces) * FEATURES
                expected[first : first + FEATURES] = features
                ways += 1
            assert np.abs(found[0, row["direction"]] - expected).max() < 1e-5
    assert ways > 400


def test_links_of_many_ends_are_those_of_each_pair(scene: map2aps.Scene, outdoors: np.ndarray) -> None:
    view = map2aps.PolarView(scene)
    tx, rx = outdoors[:2], outdoors[10:14]
    links = view.input(tx, rx)
    assert links.shape == (8, 180, 210) and np.isfinite(links).all()
    for link, (t, r) in enumerate((t, r) for t in tx for r in rx):
        assert np.array_equal(view.input(t, r)[0], links[link])
    for same in [rx.astype(np.float32), np.repeat(rx, 2, axis=0)[::2], np.asfortranarray(rx), rx.tolist()]:
        assert np.array_equal(view.input(tx, same), links)
    for ends in ((tx, np.zeros((0, 2))), (np.zeros((0, 2)), rx), (np.zeros((0, 2)), np.zeros((0, 2)))):
        assert view.input(*ends).shape == (0, 180, 210)
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
            view.input(tx, rx)
    with pytest.raises(TypeError, match="Scene"):
        map2aps.PolarView([HOUSE])
    with pytest.raises(MemoryError, match="rx: links: 121000000 of"):
        view.input(np.full((11_000, 2), 1.0), np.full((11_000, 2), 2.0))
