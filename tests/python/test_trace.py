import copy
import pickle
from typing import Any

import numpy as np
import pytest

import map2aps
from map2aps._paths import COLUMNS
from shapes import HOUSE


def test_around_one_house_the_paths_are_those_of_the_geometry() -> None:
    scene = map2aps.Scene.from_polygons([[(0, 0), (20, 0), (20, 10), (0, 10)]])
    paths = map2aps.Tracer(scene, limits="r2d1").trace((-5.0, 15.0), (25.0, 15.0))
    # Line of sight, a reflection at the upper wall, diffractions at its corners.
    assert len(paths) == 1 and len(paths.delay_s) == 4
    assert np.isclose(paths.delay_s[0] * 299_792_458.0, 30.0, rtol=1e-15)
    assert paths.departure_azimuth_rad[0] == 0.0 and paths.arrival_azimuth_rad[0] == np.pi
    wavelength = 299_792_458.0 / 3.5e9
    assert np.isclose(paths.gain_db[0], 20 * np.log10(wavelength / (4 * np.pi * 30.0)), atol=1e-9)
    assert sorted(paths.interaction_kind.tolist()) == [0, 1, 1]
    assert np.allclose(paths.interaction_point_m[:, 1], 10.0)


def test_links_of_many_ends_are_those_of_each_pair(scene: map2aps.Scene, outdoors: np.ndarray) -> None:
    tracer = map2aps.Tracer(scene)
    tx, rx = outdoors[:3], outdoors[10:15]
    paths = tracer.trace(tx, rx)
    assert len(paths) == 15 and paths.link.max() == 14
    for link, (t, r) in enumerate((t, r) for t in tx for r in rx):
        alone, one = tracer.trace(t, r), paths[link]
        for name in ("delay_s", "gain", "arrival_azimuth_rad", "interaction_id", "interaction_point_m", "interaction_offset"):
            assert np.array_equal(getattr(alone, name), getattr(one, name)), name
        assert np.array_equal(paths.tx_m[link], t) and np.array_equal(paths.rx_m[link], r)
    # The same links as pairs in another order, one of them twice.
    order = [7, 0, 14, 7, 3]
    pairs = tracer.trace_pairs(paths.tx_m[order], paths.rx_m[order])
    assert len(pairs) == 5
    for link, row in enumerate(order):
        assert np.array_equal(pairs[link].gain, paths[row].gain) and np.array_equal(pairs.rx_m[link], paths.rx_m[row])
    with pytest.raises(ValueError, match="rx: 5 points for 3 transmitters: there must be one each"):
        tracer.trace_pairs(tx, rx)
    inside = np.argwhere(scene.raster() > 0)[0][::-1] + 0.5
    with pytest.raises(ValueError, match="link 1: terminal at"):
        tracer.trace_pairs(tx[:2], [rx[0], inside])


def test_columns_have_the_types_and_lengths_that_they_are_documented_with(paths: map2aps.Paths) -> None:
    count, events = len(paths.delay_s), len(paths.interaction_kind)
    expected = {
        "path_offset": (np.int64, (len(paths) + 1,)),
        "delay_s": (np.float64, (count,)),
        "departure_azimuth_rad": (np.float64, (count,)),
        "arrival_azimuth_rad": (np.float64, (count,)),
        "gain": (np.complex128, (count,)),
        "interaction_offset": (np.int64, (count + 1,)),
        "interaction_kind": (np.uint8, (events,)),
        "interaction_id": (np.uint32, (events,)),
        "interaction_point_m": (np.float64, (events, 2)),
        "tx_m": (np.float64, (len(paths), 2)),
        "rx_m": (np.float64, (len(paths), 2)),
    }
    for name, (dtype, shape) in expected.items():
        column = getattr(paths, name)
        assert (column.dtype, column.shape) == (np.dtype(dtype), shape), name
    assert paths.path_offset[-1] == count and paths.interaction_offset[-1] == events
    assert repr(paths) == f"Paths(100 links, {count} paths)"


def test_limits_are_kept(scene: map2aps.Scene, outdoors: np.ndarray) -> None:
    tx, rx = outdoors[0], outdoors[10:60]
    few = map2aps.Tracer(scene, max_reflections=1, max_diffractions=0, dynamic_range_db=None).trace(tx, rx)
    assert few.interaction_kind.max(initial=0) == 0
    assert np.diff(few.interaction_offset).max() <= 1
    narrow = map2aps.Tracer(scene, dynamic_range_db=10).trace(tx, rx)
    for one in (narrow[i] for i in range(len(narrow))):
        assert np.ptp(one.gain_db) <= 10.0 if len(one.delay_s) else True
    metal = map2aps.Tracer(scene, material="pec", frequency_hz=28e9).trace(tx, rx)
    glass = map2aps.Tracer(scene, material=(6.3, 0.004), frequency_hz=28e9).trace(tx, rx)
    assert metal.gain_db.sum() != glass.gain_db.sum()


def test_the_slope_matters_from_corner_to_corner_alone(scene: map2aps.Scene, outdoors: np.ndarray) -> None:
    def traced(**limits: object) -> map2aps.Paths:
        return map2aps.Tracer(scene, max_reflections=0, dynamic_range_db=None, **limits).trace(outdoors[0], outdoors[10:40])

    for corners in (1, 2):
        on, off = (traced(max_diffractions=corners, slope_diffraction=value) for value in (True, False))
        assert np.array_equal(on.gain, traced(max_diffractions=corners).gain)
        assert np.array_equal(on.gain, off.gain) == (corners == 1)


def test_a_link_without_a_path_goes_on_over_corners_if_it_may() -> None:
    sight: dict[str, int] = {"max_reflections": 0, "max_diffractions": 0}
    scene, ends = map2aps.Scene.from_polygons([HOUSE]), ((50.0, 30.0), (50.0, 70.0))
    assert len(map2aps.Tracer(scene, **sight).trace(*ends).delay_s) == 0
    assert len(map2aps.Tracer(scene, **sight, max_fallback_diffractions=1).trace(*ends).delay_s) == 0
    around = map2aps.Tracer(scene, **sight, max_fallback_diffractions=2).trace(*ends)
    # Straight to a corner, along the side, and straight on: 10 sqrt(2) + 20 + 10 sqrt(2) m.
    assert len(around.delay_s) > 0 and set(around.interaction_kind) == {1}
    assert np.isclose(around.delay_s[0] * 299_792_458.0, 20.0 + 20.0 * np.sqrt(2.0), rtol=1e-12)


def test_a_trace_beyond_its_memory_is_refused(scene: map2aps.Scene, outdoors: np.ndarray) -> None:
    for limit in ("max_wave_bytes", "max_images"):
        with pytest.raises(ValueError, match=limit):
            map2aps.Tracer(scene, max_diffractions=2, **{limit: 1}).trace(outdoors[0], outdoors[10:20])


def test_a_tracer_knows_its_scene(scene: map2aps.Scene) -> None:
    assert map2aps.Tracer(scene).scene is scene


def test_settings_that_are_unknown_or_out_of_range_are_named(scene: map2aps.Scene) -> None:
    for limits, error, told in [
        ({"reflections": 2}, TypeError, "reflections"),
        ({"max_reflections": 1.5}, ValueError, "max_reflections: .*float 1.5"),
        ({"frequency_hz": "3.5e9"}, ValueError, "frequency_hz: .*str"),
        ({"dynamic_range_db": [60]}, ValueError, "dynamic_range_db: .*list"),
        ({"material": 5}, ValueError, "material: 5 is neither"),
        ({"max_reflections": 10_000}, ValueError, "max_reflections"),
        ({"frequency_hz": -1.0}, ValueError, "frequency"),
        ({"frequency_hz": np.nan}, ValueError, "frequency"),
        ({"dynamic_range_db": -3.0}, ValueError, "dynamic range"),
        ({"material": "wood"}, ValueError, "'wood'"),
        ({"material": (0.5, 0.0)}, ValueError, "permittivity"),
        ({"max_images": -1}, ValueError, "max_images: expected an integer from 0 .*int -1"),
        ({"max_wave_bytes": 0.5}, ValueError, "max_wave_bytes: .*float 0.5"),
        ({"slope_diffraction": 1}, ValueError, "slope_diffraction: expected True or False, got int 1"),
        ({"max_fallback_diffractions": 1001}, ValueError, "max_fallback_diffractions"),
    ]:
        with pytest.raises(error, match=told):
            map2aps.Tracer(scene, **limits)


def test_ends_that_cannot_stand_where_they_are_are_named(outdoors: np.ndarray) -> None:
    tracer = map2aps.Tracer(map2aps.Scene.from_polygons([HOUSE]))
    out = (10.0, 10.0)
    for tx, rx, told in [
        ((50.0, 50.0), out, "transmitter 0: .* inside building 0"),
        (out, [(1.0, 1.0), (50.0, 50.0)], "receiver 1: .* inside building 0"),
        (out, (40.0, 50.0), "on wall"),
        (out, (np.nan, 1.0), "finite"),
        (out, (np.inf, 1.0), "finite"),
        (out, [out], "receiver 0: .*both at"),
        ([1.0], out, r"tx: .*float64 of shape \(1,\)"),
        (out, np.zeros((2, 2, 2)), r"rx: .*float64 of shape \(2, 2, 2\)"),
        (out, np.zeros((2, 2), complex), r"rx: .*complex128 of shape \(2, 2\)"),
        (out, np.array([[1, 2]], object), r"rx: .*object of shape \(1, 2\)"),
    ]:
        with pytest.raises(ValueError, match=told):
            tracer.trace(tx, rx)


def test_no_receivers_make_no_links(scene: map2aps.Scene, outdoors: np.ndarray) -> None:
    paths = map2aps.Tracer(scene).trace(outdoors[0], np.zeros((0, 2)))
    assert len(paths) == 0 and len(paths.delay_s) == 0 and paths.path_offset.tolist() == [0]
    assert map2aps.label(paths).aps_db.shape == (0, 180)
    with pytest.raises(IndexError, match="link: 0 is none of 0 links"):
        paths[0]
    assert len(map2aps.Tracer(scene).trace(np.zeros((0, 2)), outdoors[:3])) == 0
    with pytest.raises(ValueError, match=r"tx: .*float64 of shape \(0,\)"):
        map2aps.Tracer(scene).trace([], outdoors[:3])


def test_single_precision_and_views_give_the_same_paths(scene: map2aps.Scene, outdoors: np.ndarray) -> None:
    tracer = map2aps.Tracer(scene)
    tx, rx = outdoors[0], outdoors[10:30]
    expected = tracer.trace(tx, rx)
    for same in [rx.astype(np.float32), rx.astype(np.int64), np.repeat(rx, 2, axis=0)[::2], np.asfortranarray(rx), rx.tolist()]:
        assert np.array_equal(tracer.trace(tx, same).gain, expected.gain)


def test_paths_can_be_pickled_and_given_by_other_programs(paths: map2aps.Paths) -> None:
    back = pickle.loads(pickle.dumps(paths))
    assert np.array_equal(back.gain, paths.gain) and len(back) == len(paths)
    other = map2aps.Paths.from_arrays(paths.path_offset, paths.delay_s, paths.arrival_azimuth_rad, paths.gain)
    assert np.array_equal(map2aps.label(other).aps_db, map2aps.label(paths).aps_db, equal_nan=True)
    assert np.array_equal(paths[-1].gain, paths[len(paths) - 1].gain)
    some = pickle.loads(pickle.dumps(paths[3:9:2]))
    for link, one in zip((3, 5, 7), (some[i] for i in range(len(some)))):
        for name in ("gain", "interaction_kind", "interaction_id", "interaction_offset", "tx_m", "rx_m"):
            assert np.array_equal(getattr(one, name), getattr(paths[link], name)), name
    assert len(paths[5:5]) == 0 and copy.deepcopy(paths[5:5]).path_offset.tolist() == [0]


def test_paths_are_read_alone_and_others_are_made_of_them(paths: map2aps.Paths) -> None:
    with pytest.raises(ValueError, match="read-only"):
        paths.gain[0] = 0.0
    with pytest.raises(AttributeError, match=r"replace\(gain=...\)"):
        paths.gain = np.zeros(3)
    weaker = paths.replace(gain=paths.gain / 10.0)
    assert np.array_equal(weaker.interaction_point_m, paths.interaction_point_m)
    expected, found = map2aps.label(paths), map2aps.label(weaker)
    assert np.allclose(found.aps_db[found.is_labelled], expected.aps_db[expected.is_labelled] - 20.0, atol=1e-9)
    columns = {name: getattr(paths, name) for name in COLUMNS}
    assert np.array_equal(map2aps.Paths(**columns).gain, paths.gain)
    # Of Python 3.13 on, which calls that method.
    replace = getattr(copy, "replace", map2aps.Paths.__replace__)
    for again in (paths.__replace__(gain=paths.gain / 10.0), replace(paths, gain=paths.gain / 10.0)):
        assert np.array_equal(again.gain, weaker.gain) and np.array_equal(again.path_offset, paths.path_offset)
    with pytest.raises(TypeError, match="Paths have no gains"):
        paths.__replace__(gains=paths.gain)
    with pytest.raises(TypeError, match="Paths have no gains"):
        map2aps.Paths(**columns, gains=paths.gain)
    del columns["rx_m"]
    with pytest.raises(TypeError, match="no column rx_m"):
        map2aps.Paths(**columns)


def test_a_tracer_tells_its_scene_and_limits(scene: map2aps.Scene) -> None:
    assert repr(map2aps.Tracer(scene, max_reflections=1, material="pec")) == f"Tracer({scene!r}, max_reflections=1, material='pec')"


def test_limits_have_names_and_single_settings_change_them() -> None:
    scene = map2aps.Scene.synthetic(seed=1)
    numbers = {"max_reflections": 5, "max_diffractions": 2, "dynamic_range_db": 20.0}
    tx, rx = (2.0, 2.0), (30.0, 2.0)

    def gains(**limits: Any) -> Any:
        return map2aps.Tracer(scene, **limits).trace(tx, rx).gain.tolist()

    r2d1 = gains(limits="r2d1")
    assert gains() == gains(limits="converged") == gains(limits="r2d1", **numbers) != r2d1
    assert r2d1 == gains(max_reflections=2, max_diffractions=1, dynamic_range_db=60.0)
    assert gains(dynamic_range_db=30.0) == gains(**{**numbers, "dynamic_range_db": 30.0})
    with pytest.raises(ValueError, match="neither 'converged' nor 'r2d1'"):
        gains(limits="R5D2")
