import json
import warnings
from pathlib import Path

import numpy as np
import pytest

import map2aps
from shapes import HELSINKI, HOUSE, geojson


def test_a_house_is_not_outdoors_and_neither_is_its_wall() -> None:
    scene = map2aps.Scene.from_polygons([HOUSE])
    points = [(50.0, 50.0), (40.0, 50.0), (39.0, 50.0), (-1e6, 0.0)]
    assert scene.is_outdoor(points).tolist() == [False, False, True, True]
    assert scene.is_outdoor((39.0, 50.0)).tolist() == [True]
    assert scene.area is None


def test_an_area_confines_points() -> None:
    scene = map2aps.Scene.from_polygons([HOUSE], area=(0.0, 0.0, 100.0, 100.0))
    assert scene.is_outdoor([(10.0, 10.0), (110.0, 10.0)]).tolist() == [True, False]
    assert scene.area == [0.0, 0.0, 100.0, 100.0]


def test_polygons_come_back_as_outlines_and_walls() -> None:
    scene = map2aps.Scene.from_polygons([HOUSE[::-1], HOUSE + 100.0])
    assert [ring.shape for ring in scene.outlines] == [(4, 2), (4, 2)]
    assert np.array_equal(scene.outlines[0], HOUSE)
    assert scene.walls.shape == (8, 2, 2)
    assert "1 reoriented" in scene.repairs
    assert map2aps.Scene.from_polygons([HOUSE]).repairs == ""
    assert repr(scene) == "Scene(2 buildings, 8 walls)"


def test_courtyards_stand_behind_the_outline_of_their_building() -> None:
    yard = [(46.0, 46.0), (54.0, 46.0), (54.0, 54.0), (46.0, 54.0)]
    points = [(50.0, 50.0), (43.0, 50.0), (103.0, 150.0), (105.5, 150.5), (98.0, 150.0)]
    other = [HOUSE + (60.0, 100.0), HOUSE[:3] / 10.0 + (100.0, 146.0), HOUSE / 10.0 + (110.0, 146.0)]
    for polygons in ([[HOUSE, yard], other], [[HOUSE.tolist(), yard], tuple(other)], [np.stack([HOUSE, yard]), other]):
        scene = map2aps.Scene.from_polygons(polygons)
        assert scene.is_outdoor(points).tolist() == [True, False, False, True, True]
        assert len(scene.outlines) == 5 and scene.walls.shape == (19, 2, 2)
    assert map2aps.Scene.from_polygons([[HOUSE], HOUSE + 100.0]).repairs == ""


def test_a_raster_shows_the_house() -> None:
    scene = map2aps.Scene.from_polygons([HOUSE], area=(0.0, 0.0, 100.0, 100.0))
    raster = scene.raster(100)
    assert raster.dtype == np.uint8
    assert raster[50, 50] == 1 and raster[50, 30] == 0 and raster[70, 50] == 0
    assert abs(int(raster.sum()) - 400) < 100
    assert scene.raster().shape == (256, 256)


def test_a_raster_needs_a_square_area_from_zero() -> None:
    for area in [None, (0.0, 0.0, 100.0, 50.0), (1.0, 1.0, 101.0, 101.0)]:
        with pytest.raises(ValueError, match="square area"):
            map2aps.Scene.from_polygons([HOUSE], area=area).raster(64)
    with pytest.raises(ValueError):
        map2aps.Scene.synthetic().raster(0)
    with pytest.raises(ValueError, match="size: expected an integer .*, got bool True"):
        map2aps.Scene.synthetic().raster(True)


def test_synthetic_cities_repeat_by_seed() -> None:
    first, again, other = (map2aps.Scene.synthetic(seed) for seed in (1, 1, 2))
    assert np.array_equal(first.walls, again.walls)
    assert not np.array_equal(first.walls, other.walls)


def test_maps_are_read_from_files(tmp_path: Path) -> None:
    file = tmp_path / "0.json"
    file.write_text(json.dumps([HOUSE.tolist()]))
    scene = map2aps.Scene.from_radiomapseer(file)
    assert scene.area == [0.0, 0.0, 256.0, 256.0] and len(scene.walls) == 4
    assert len(map2aps.Scene.from_radiomapseer(str(file), close_gaps_m=0.0).walls) == 4

    city = geojson(tmp_path / "city.geojson", HOUSE, building="yes")
    scene = map2aps.Scene.from_geojson(city, metric=True, tile_m=128.0)
    assert scene.area == [0.0, 0.0, 128.0, 128.0] and len(scene.walls) == 4
    with pytest.raises(ValueError, match="tile 7"):
        map2aps.Scene.from_geojson(city, metric=True, tile=7)


def test_slits_are_closed_below_a_width(tmp_path: Path) -> None:
    city = geojson(tmp_path / "city.geojson", HOUSE, HOUSE + (20.5, 0.0), building="yes")
    for width_m, houses in ((None, 2), (0.4, 2), (0.6, 1)):
        assert len(map2aps.Scene.from_geojson(city, metric=True, close_gaps_m=width_m).outlines) == houses


def test_polygons_without_a_tag_are_buildings_if_all_are(tmp_path: Path) -> None:
    city = geojson(tmp_path / "city.geojson", HOUSE, landuse="grass")
    for is_none in ({}, {"all_polygons": False}):
        with pytest.raises(ValueError, match="building"):
            map2aps.Scene.from_geojson(city, metric=True, **is_none)
    assert len(map2aps.Scene.from_geojson(city, metric=True, all_polygons=True).walls) == 4


def test_features_that_are_no_building_are_told(tmp_path: Path) -> None:
    city = geojson(tmp_path / "city.geojson", HOUSE, building="yes")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        map2aps.Scene.from_geojson(city, metric=True)
    whole = json.loads(city.read_text())
    whole["features"] += json.loads(geojson(tmp_path / "park.geojson", HOUSE + 50.0, HOUSE + 80.0, leisure="park").read_text())["features"]
    city.write_text(json.dumps(whole))
    few = {"tx_per_map": 1, "rx_per_map": 2, "metric": True, "progress": None}
    for call in (lambda: map2aps.Scene.from_geojson(city, metric=True), lambda: map2aps.make_dataset(tmp_path / "set", city, **few)):
        with pytest.warns(UserWarning, match="city.geojson: 2 features that are no building passed over; all_polygons=True") as told:
            call()
        assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(map2aps.Scene.from_geojson(city, metric=True, all_polygons=True).outlines) == 3
        with pytest.raises(UserWarning, match="no building"):
            map2aps.make_dataset(tmp_path / "other", city, **few)
    assert not (tmp_path / "other").exists()


def test_errors_of_a_city_name_the_argument_that_helps(tmp_path: Path) -> None:
    metres = geojson(tmp_path / "metres.geojson", HOUSE * 10.0, building="yes")
    with pytest.raises(ValueError, match=r"metric=True takes its numbers for metres"):
        map2aps.Scene.from_geojson(metres)
    park = geojson(tmp_path / "park.geojson", HOUSE, leisure="park")
    for call in (map2aps.Scene.from_geojson, lambda file, metric: map2aps.make_dataset(tmp_path / "set", file, metric=metric, progress=None)):
        with pytest.raises(ValueError, match=r"`building` tag.*all_polygons=True takes untagged ones"):
            call(park, metric=True)


@pytest.mark.parametrize("latitude_deg", [0.0, 60.0])
def test_degrees_become_metres(tmp_path: Path, latitude_deg: float) -> None:
    # On a sphere of 6371 km a degree of latitude is 111.195 km; the earth is one within 0.6 %.
    side_m = 111_194.9 * 2e-4
    square = np.array([(0.0, 0.0), (2e-4, 0.0), (2e-4, 2e-4), (0.0, 2e-4)]) + (25.0, latitude_deg)
    city = geojson(tmp_path / "city.geojson", square, building="yes")
    for scene in (map2aps.Scene.from_geojson(city), map2aps.Scene.from_geojson(str(city), tile=0, metric=False)):
        size = np.ptp(scene.walls.reshape(-1, 2), axis=0)
        assert np.allclose(size, side_m * np.array([np.cos(np.deg2rad(latitude_deg)), 1.0]), rtol=0.006)
        assert scene.area == [0.0, 0.0, 256.0, 256.0]


def test_a_city_of_open_street_map_has_its_tiles() -> None:
    whole, tile = (map2aps.Scene.from_geojson(HELSINKI, tile_m=side) for side in (1000.0, 100.0))
    assert whole.area == [0.0, 0.0, 1000.0, 1000.0] and tile.area == [0.0, 0.0, 100.0, 100.0]
    assert 0 < len(tile.walls) < len(whole.walls)
    assert whole.raster(100).any() and not whole.raster(100).all()


def test_files_that_are_missing_or_no_maps_are_refused(tmp_path: Path) -> None:
    for read in (map2aps.Scene.from_radiomapseer, map2aps.Scene.from_geojson):
        with pytest.raises(FileNotFoundError, match="none.json"):
            read(tmp_path / "none.json")
    (tmp_path / "bad.json").write_text("[[[1, 2], [3")
    with pytest.raises(ValueError, match="bad.json"):
        map2aps.Scene.from_radiomapseer(tmp_path / "bad.json")
    with pytest.raises(OSError):
        map2aps.Scene.from_radiomapseer(tmp_path)


@pytest.mark.parametrize(
    ("points", "told"),
    [
        ([1.0, 2.0, 3.0], r"float64 of shape \(3,\)"),
        (np.zeros((2, 3)), r"points_m: .*float64 of shape \(2, 3\)"),
        (np.zeros((2, 2), complex), r"complex128 of shape \(2, 2\)"),
        ([["a", "b"]], r"<U1 of shape \(1, 2\)"),
        (np.zeros((2, 2), bool), r"bool of shape \(2, 2\)"),
        ([[1.0, np.nan]], "row 0"),
        ([[0.0, 0.0], [np.inf, 1.0]], "row 1"),
    ],
)
def test_points_of_another_kind_or_shape_are_named(scene: map2aps.Scene, points: object, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        scene.is_outdoor(points)


def test_polygons_of_another_kind_or_shape_are_named() -> None:
    with pytest.raises(ValueError, match=r"polygons.*shape \(4, 3\)"):
        map2aps.Scene.from_polygons([np.zeros((4, 3))])
    with pytest.raises(ValueError, match="complex"):
        map2aps.Scene.from_polygons([HOUSE.astype(complex)])
    with pytest.raises(ValueError, match="building 0, ring 0, vertex 1"):
        map2aps.Scene.from_polygons([np.array([[0.0, 0.0], [np.nan, 1.0], [1.0, 1.0]])])
    with pytest.raises(ValueError, match="building 0, ring 1, vertex 2"):
        map2aps.Scene.from_polygons([[HOUSE, [(45.0, 45.0), (50.0, 45.0), (50.0, np.inf)]]])
    for polygons, told in [
        ([[HOUSE, np.zeros((4, 3))]], r"float64 of shape \(4, 3\)"),
        ([[HOUSE, []]], r"float64 of shape \(0,\)"),
        ([[]], r"float64 of shape \(0,\)"),
        ([[[]]], r"float64 of shape \(1, 0\)"),
        ([["ab", "cd"]], r"<U2 of shape \(\)"),
        (HOUSE, r"float64 of shape \(2,\)"),
        ([5.0], r"float64 of shape \(\)"),
        (5, "sequence of polygons, got int"),
        (None, "sequence of polygons, got NoneType"),
    ]:
        with pytest.raises(ValueError, match=f"polygons: expected .*{told}"):
            map2aps.Scene.from_polygons(polygons)
    for area in [(5.0, 5.0, 1.0, 1.0), (0.0, 0.0, 1.0), "abcd", 5, (0.0, 0.0, None, 1.0), (0.0, np.nan, 9.0, 9.0)]:
        with pytest.raises(ValueError, match="area"):
            map2aps.Scene.from_polygons([HOUSE], area=area)


def test_numbers_out_of_range_or_of_another_type_are_named(scene: map2aps.Scene, tmp_path: Path) -> None:
    city = tmp_path / "city.geojson"
    for call, told in [
        (lambda: map2aps.Scene.synthetic(-1), "seed: expected an integer from 0 to .*, got int -1"),
        (lambda: map2aps.Scene.synthetic(1.5), "seed: .*float 1.5"),
        (lambda: map2aps.Scene.synthetic(close_gaps_m="0"), "close_gaps_m: expected a real number, got str '0'"),
        (lambda: map2aps.Scene.from_polygons([HOUSE], close_gaps_m=np.nan), "close"),
        (lambda: map2aps.Scene.from_polygons([HOUSE], close_gaps_m=-1), "close"),
        (lambda: map2aps.Scene.from_geojson(city, tile=-1), "tile: .*int -1"),
        (lambda: map2aps.Scene.from_geojson(city, tile_m=1j), "tile_m: .*complex 1j"),
        (lambda: scene.raster(-1), "size: .*int -1"),
        (lambda: scene.raster(2.0), "size: .*float 2.0"),
        (lambda: scene.raster(10**30), "size: .*int 10"),
        (lambda: scene.raster(10**9), "raster|pixels"),
    ]:
        with pytest.raises(ValueError, match=told):
            call()


def test_nothing_has_no_walls_and_no_points_make_no_answers() -> None:
    scene = map2aps.Scene.from_polygons([])
    assert scene.walls.shape == (0, 2, 2) and scene.outlines == []
    assert scene.is_outdoor(np.zeros((0, 2))).shape == (0,)
    assert not map2aps.Scene.from_polygons([], area=(0.0, 0.0, 64.0, 64.0)).raster(64).any()


def test_integers_single_precision_and_views_are_as_good(scene: map2aps.Scene) -> None:
    points = np.stack([np.arange(0.0, 256.0, 7.0), np.arange(256.0, 0.0, -7.0)[:37]], 1)
    expected = scene.is_outdoor(points)
    spread = np.zeros((37, 4))
    spread[:, ::2] = points
    for same in [points.astype(np.float32), points.astype(np.int32), spread[:, ::2], np.asfortranarray(points)]:
        assert np.array_equal(scene.is_outdoor(same), expected)


def test_polygons_of_single_precision_integers_and_views_make_the_same_scene() -> None:
    yard = np.array([(46.0, 46.0), (54.0, 46.0), (54.0, 54.0), (46.0, 54.0)])
    expected = map2aps.Scene.from_polygons([[HOUSE, yard], HOUSE + 100.0])
    for same in (np.float32, np.int16, lambda ring: np.repeat(ring, 2, axis=0)[::2], np.asfortranarray, lambda ring: ring[::-1][::-1]):
        scene = map2aps.Scene.from_polygons([[same(HOUSE), same(yard)], same(HOUSE + 100.0)])
        assert np.array_equal(scene.walls, expected.walls) and scene.repairs == expected.repairs
