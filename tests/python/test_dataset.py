import json
import os
import pickle
import shutil
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import map2aps
from map2aps import _native
from shapes import HELSINKI, HOUSE, geojson


def test_a_data_set_has_its_maps_and_arrays(data: Path) -> None:
    dataset = map2aps.Dataset(str(data))
    with pytest.raises(ValueError, match="'training'"):
        dataset.split("training")
    assert len(dataset) == 6 and dataset.links == 72
    assert sorted(i for part in ("train", "develop", "test") for i in dataset.split(part)) == list(range(6))
    for one in dataset:
        assert one.links == 12 and {"tx", "rx", "aps_db", "path_offset", "pdp_db"} <= set(one.keys())
        assert one["aps_db"].shape == (12, 180) and one["tx"].shape == (2, 2)
        assert isinstance(one["aps_db"], np.memmap) and not one["aps_db"].flags.writeable
        assert one.is_valid.all()
    assert dataset.angle_deg[0] == -180.0 and len(dataset.angle_deg) == 180
    assert repr(dataset[0]) == "Map(0, 12 links)" and "6 maps, 72 links" in repr(dataset)


def test_stored_labels_are_those_of_the_stored_paths(data: Path) -> None:
    one = map2aps.Dataset(data)[3]
    paths = map2aps.Paths.from_arrays(one["path_offset"], one["path_delay_s"], one["path_arrival_azimuth_rad"], one["path_gain"])
    label = map2aps.label(paths, "released")
    stored = one["aps_db"].astype(np.float64) + one["aps_max_db"][:, None]
    near = label.aps_db > label.aps_db.max(1, keepdims=True) - 60.0
    assert np.abs(stored - label.aps_db)[near].max() < 0.02


def test_the_same_call_makes_the_same_bytes_and_keeps_what_is_there(data: Path, tmp_path: Path) -> None:
    settings = {"tx_per_map": 2, "rx_per_map": 6, "store_paths": True, "store_pdp": True, "protocol": "released"}
    calls: list[tuple[int, int]] = []
    map2aps.make_dataset(tmp_path / "again", 6, **settings, progress=lambda *of: calls.append(of))
    for file in sorted(data.rglob("*")):
        if file.is_file():
            assert (tmp_path / "again" / file.relative_to(data)).read_bytes() == file.read_bytes(), file
    assert calls[-1] == (72, 72)
    map2aps.make_dataset(tmp_path / "again", 6, **settings, progress=None)
    with pytest.raises(ValueError, match="seed"):
        map2aps.make_dataset(tmp_path / "again", 6, **settings, seed=1, progress=None)


def test_stored_paths_are_labelled_anew_as_label_does(data: Path, tmp_path: Path) -> None:
    array = map2aps.UniformCircular(8, 0.5)
    new = map2aps.relabel(data, tmp_path / "new", protocol="paper", array=array, store_pdp=True)
    assert new.protocol == "paper" and new.split("test") == map2aps.Dataset(data).split("test")
    one = new[3]
    paths = map2aps.Paths.from_arrays(one["path_offset"], one["path_delay_s"], one["path_arrival_azimuth_rad"], one["path_gain"])
    label = map2aps.label(paths, "paper", array)
    stored = one["aps_db"].astype(np.float64) + one["aps_max_db"][:, None]
    near = label.aps_db > label.aps_db.max(1, keepdims=True) - 60.0
    assert np.abs(stored - label.aps_db)[near].max() < 0.02
    # What is not given is as it was.
    again = map2aps.relabel(new, tmp_path / "again", protocol="released", store_paths=False, progress=None)
    settings = again.manifest["configuration"]["label"]
    assert settings["array"] == new.manifest["configuration"]["label"]["array"] and settings["protocol"] == "released"
    assert "path_offset" not in again[3].keys()
    with pytest.raises(ValueError, match="store_paths=True"):
        map2aps.relabel(again, tmp_path / "none")


def test_training_maps_are_made_in_several_orientations(tmp_path: Path) -> None:
    made = map2aps.make_dataset(tmp_path, 3, tx_per_map=1, rx_per_map=2, orientations=2, progress=None)
    assert len(made) == 4 and [i % 1_000_000 for i in made.split("train")] == [made.split("train")[0]] * 2
    with pytest.raises(ValueError, match="1 to 8 orientations"):
        map2aps.make_dataset(tmp_path / "nine", 3, orientations=9)


def test_settings_of_tiles_are_for_cities(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="city in GeoJSON"):
        map2aps.make_dataset(tmp_path / "none", 3, metric=True)


def test_an_exception_of_the_callback_ends_the_making_which_goes_on_later(tmp_path: Path) -> None:
    class Enough(Exception):
        pass

    def stop(done: int, total: int) -> None:
        if done > 0:
            raise Enough

    settings = {"tx_per_map": 5, "rx_per_map": 100, "receivers": "outdoor"}
    with pytest.raises(Enough):
        map2aps.make_dataset(tmp_path / "set", 6, **settings, progress=stop)
    assert map2aps.make_dataset(tmp_path / "set", 6, **settings, progress=None).links == 3000


def test_maps_settings_of_labels_and_limits_reach_the_data_set(tmp_path: Path) -> None:
    dataset = map2aps.make_dataset(
        tmp_path / "set",
        10,
        map_ids=np.array([2, 9, 5])[::2],
        tx_per_map=1,
        rx_per_map=3,
        receivers="outdoor",
        seed=7,
        protocol="paper",
        array=map2aps.UniformCircular(8, 0.5),
        sampling_rate_hz=100e6,
        max_reflections=1,
        max_diffractions=1,
        dynamic_range_db=None,
        progress=None,
    )
    of = dataset.manifest["configuration"]
    assert of["trace"]["max_diffractions"] == 1 and of["trace"]["max_interactions"] == 2
    assert [one.id for one in dataset] == [2, 5] and dataset.manifest["seed"] == 7
    assert of["label"]["protocol"] == "paper" and of["label"]["sampling_rate_hz"] == 100e6
    assert of["label"]["array"] == {"uniform_circular": {"elements": 8, "radius_wavelengths": 0.5}}
    assert of["trace"]["max_reflections"] == 1 and of["trace"]["dynamic_range_db"] is None
    assert of["sampling"]["receivers"] == "outdoor"
    with pytest.raises(KeyError, match="no map 3, only 2, 5"):
        dataset[3]
    with pytest.raises(KeyError, match="map 2 has no array 'pdp_db', only .*aps_db.*; make_dataset.*store_pdp=True"):
        dataset[2]["pdp_db"]
    with pytest.raises(KeyError, match="no array 'nope', only [a-z_, ]*\"$"):
        dataset[2]["nope"]


def test_many_links_that_are_missing_are_told_with_the_reasons(tmp_path: Path) -> None:
    # In sight of a transmitter are not all of the 3,296 points that are outdoors.
    city = geojson(tmp_path / "city.geojson", HOUSE, HOUSE + 30.0, building="yes")
    sight: dict[str, Any] = {"tx_per_map": 2, "max_reflections": 0, "max_diffractions": 0, "metric": True, "tile_m": 64.0, "progress": None}
    for _ in ("made", "there already"):
        with pytest.warns(UserWarning, match=r"set: \d+ links of the 6400 asked for: .*not reached: \d+ .*receivers='outdoor'") as told:
            made = map2aps.make_dataset(tmp_path / "set", city, rx_per_map=3200, **sight)
        assert told[0].filename == __file__ and str(made.links) in str(told[0].message)
        assert made.missing_links == 6400 - made.links
        of_maps = map2aps.Dataset(made.path).manifest["maps"]
        assert made.missing_links == sum(one["statistics"]["missing_links"] for one in of_maps)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert map2aps.make_dataset(tmp_path / "none", city, rx_per_map=3, **sight).missing_links == 0
        # Up to a tenth is usual where receivers are drawn.
        few = map2aps.make_dataset(tmp_path / "few", city, rx_per_map=1850, **sight)
    assert 0 < few.missing_links == 3700 - few.links < 370


def test_a_data_set_that_does_not_tell_misses_no_links(data: Path, tmp_path: Path) -> None:
    shutil.copytree(data, tmp_path / "set")
    manifest = map2aps.Dataset(data).manifest
    for one in manifest["maps"]:
        one["statistics"] = None
    (tmp_path / "set" / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    assert map2aps.Dataset(tmp_path / "set").missing_links == 0


@pytest.mark.skipif(sys.platform != "linux", reason="there, names are Unicode")
def test_a_folder_need_not_be_named_in_utf_8(data: Path, tmp_path: Path) -> None:
    folder = tmp_path / os.fsdecode(b"caf\xe9")
    folder.symlink_to(data)
    told, expected = (json.loads(_native.training_facts(of)) for of in (folder, data))
    assert told.pop("data") == f"{tmp_path}/caf\ufffd" and expected.pop("data") == str(data)
    assert told == expected


def test_settings_that_make_no_data_set_are_named(tmp_path: Path) -> None:
    make = map2aps.make_dataset
    for call, error, told in [
        (lambda: make(tmp_path / "a", 3, map_ids=[7], progress=None), ValueError, "7"),
        (lambda: make(tmp_path / "a", 3, receivers="all", progress=None), ValueError, "receivers: 'all' is none of reached, outdoor"),
        (lambda: make(tmp_path / "a", 3, protocol="old", progress=None), ValueError, "`old`"),
        (lambda: make(tmp_path / "a", 3, reflections=3, progress=None), TypeError, "reflections"),
        (lambda: make(tmp_path / "a", tmp_path / "none", progress=None), OSError, "none"),
        (lambda: make(tmp_path / "a", tmp_path, progress=None), ValueError, "map"),
        (lambda: make("/proc/none/set", 1, progress=None), OSError, "cannot create"),
        (lambda: map2aps.Dataset(tmp_path), ValueError, "not a data set"),
        (lambda: map2aps.Dataset(tmp_path / "none"), FileNotFoundError, "none"),
        (lambda: make(tmp_path / "a", tmp_path / "none.geojson", progress=None), FileNotFoundError, "none"),
        (lambda: make(tmp_path / "a", 3, map_ids=[], progress=None), ValueError, "map_ids: no map"),
        (lambda: make(tmp_path / "a", 3, map_ids=np.array([2**64 - 1], np.uint64), progress=None), ValueError, str(2**64 - 1)),
        (lambda: make(tmp_path / "a", 10**9, map_ids=[0], progress=None), ValueError, "1000000000 synthetic cities"),
        (lambda: make(tmp_path / "a", True, progress=None), ValueError, "maps.*bool True"),
        (lambda: make(tmp_path / "a", 3, rx_per_map=0, progress=None), ValueError, "at least 1 transmitter and 1 receiver"),
        (lambda: make(tmp_path / "a", 3, tile_m=np.nan, progress=None), ValueError, "tile_m: NaN"),
        (lambda: make(tmp_path / "a", 3, metric="no", progress=None), ValueError, "metric: expected True or False, got str 'no'"),
        (lambda: make(tmp_path / "a", 3, receivers=None, progress=None), ValueError, "receivers: expected a string, got NoneType"),
        (lambda: make(tmp_path / "a", 3, progress=5), TypeError, "progress: .*int 5"),
        (lambda: make(tmp_path / "a", 3, seed=10**300, progress=None), ValueError, r"seed: .* got int 1000*\.\.\.$"),
        (lambda: make(tmp_path / "a", 3, frequency_hz=1e300, progress=None), ValueError, r"digits\)"),
        (lambda: make(tmp_path / "a", -1, progress=None), ValueError, "maps.*int -1"),
        (lambda: make(tmp_path / "a", 1.5, progress=None), ValueError, "maps.*float 1.5"),
        (lambda: make(tmp_path / "a", 3, map_ids=[-1], progress=None), ValueError, "map_ids: .*-1 is out of range"),
        (lambda: make(tmp_path / "a", 3, map_ids=[0.5], progress=None), ValueError, "map_ids: expected integers .*float64"),
        (lambda: make(tmp_path / "a", 3, tx_per_map=-1, progress=None), ValueError, "tx_per_map: .*int -1"),
        (lambda: make(tmp_path / "a", 3, rx_per_map="9", progress=None), ValueError, "rx_per_map: .*str '9'"),
        (lambda: make(tmp_path / "a", 3, seed=-1, progress=None), ValueError, "seed: .*int -1"),
        (lambda: make(tmp_path / "a", 3, sampling_rate_hz=np.nan, progress=None), ValueError, "sampling_rate_hz"),
        (lambda: make(tmp_path / "a", 3, max_reflections=-2, progress=None), ValueError, "max_reflections: .*int -2"),
        (lambda: make(tmp_path / "a", 3, array=16, progress=None), TypeError, "UniformLinear"),
    ]:
        with pytest.raises(error, match=told):
            call()


def test_arrays_may_be_empty(tmp_path: Path) -> None:
    sight = {"max_reflections": 0, "max_diffractions": 0}
    made = map2aps.make_dataset(tmp_path, 1, tx_per_map=1, rx_per_map=2, store_paths=True, progress=None, **sight)
    assert made[0]["interaction_point"].shape == (0, 2)


def test_a_data_set_is_pickled_by_its_place(data: Path) -> None:
    dataset = pickle.loads(pickle.dumps(map2aps.Dataset(str(data))))
    assert dataset.links == 72 and dataset.path == data
    one, again = dataset[3], pickle.loads(pickle.dumps(dataset[3]))
    assert (again.id, again.links, again.keys()) == (3, 12, one.keys())
    assert np.array_equal(again["aps_db"], one["aps_db"]) and isinstance(again["aps_db"], np.memmap)


def test_maps_are_those_of_a_folder(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    for map_id, place in ((0, 0.0), (7, 100.0)):
        (tmp_path / "maps" / f"{map_id}.json").write_text(json.dumps([(HOUSE + place).tolist()]))
    dataset = map2aps.make_dataset(tmp_path / "set", tmp_path / "maps", tx_per_map=1, rx_per_map=3, progress=None)
    assert [one.id for one in dataset] == [0, 7] and dataset.links == 6
    assert dataset.manifest["configuration"]["maps"] == "radiomapseer"
    for one in dataset:
        scene = map2aps.Scene.from_radiomapseer(tmp_path / "maps" / f"{one.id}.json")
        assert np.array_equal(one["buildings"], scene.raster())
        assert scene.is_outdoor(np.concatenate([one["tx"], one["rx"]])).all() and one.is_valid.all()


def test_maps_are_tiles_of_a_city_in_metres(tmp_path: Path) -> None:
    # One house in the south-west of the city, one two tiles east and one north of it.
    city = geojson(tmp_path / "city.geojson", HOUSE, HOUSE + (256.0, 128.0), building="yes")
    dataset = map2aps.make_dataset(
        tmp_path / "set", city, tile_m=128.0, metric=True, tx_per_map=1, rx_per_map=3, receivers="outdoor", progress=None
    )
    about = dataset.manifest["configuration"]["maps"]
    assert (about["kind"], about["tile_m"], about["coordinates"]) == ("geojson", 128.0, "metres")
    assert len(dataset) == 2
    for one in dataset:
        scene = map2aps.Scene.from_geojson(city, tile=one.id, tile_m=128.0, metric=True)
        assert np.array_equal(one["buildings"], scene.raster()) and len(scene.walls) == 4
        ends = np.concatenate([one["tx"], one["rx"]])
        assert scene.is_outdoor(ends).all() and ends.max() <= 128.0


def test_maps_are_tiles_of_a_city_of_open_street_map(tmp_path: Path) -> None:
    few: dict[str, object] = {"tx_per_map": 1, "rx_per_map": 3, "progress": None}
    dataset = map2aps.make_dataset(tmp_path / "set", str(HELSINKI), map_ids=(0,), **few)
    about = dataset.manifest["configuration"]["maps"]
    assert (about["tile_m"], about["coordinates"], about["buildings"]) == (256.0, "degrees", 75)
    assert np.array_equal(dataset[0]["buildings"], map2aps.Scene.from_geojson(HELSINKI, tile=0).raster())
    # Degrees are no metres: the whole city would be a thousandth of one.
    with pytest.raises(ValueError, match="no tile|unit|m long"):
        map2aps.make_dataset(tmp_path / "other", HELSINKI, metric=True, **few)


def test_an_array_of_another_shape_is_refused(data: Path, tmp_path: Path) -> None:
    copy = map2aps.make_dataset(tmp_path / "set", 1, tx_per_map=1, rx_per_map=3, progress=None)
    np.save(tmp_path / "set" / "map_0000" / "status.npy", np.zeros(5, np.uint8))
    with pytest.raises(ValueError, match=r"\(5,\).*\(3,\)"):
        copy[0]["status"]


def test_mirror_images_of_another_array_are_refused_with_the_remedy(tmp_path: Path) -> None:
    circular = map2aps.UniformCircular(8, 0.5)
    made = map2aps.make_dataset(tmp_path, 3, tx_per_map=1, rx_per_map=2, array=circular, progress=None)
    with pytest.raises(ValueError, match="uniform_circular.*mirror=False leaves the mirror images out"):
        map2aps.Examples(made.path, "train")
    assert len(map2aps.Examples(made.path, "train", mirror=False)) > 0


def test_a_model_without_images_is_told_its_condition(data: Path) -> None:
    with pytest.raises(ValueError, match="size: None.*condition='polar'"):
        map2aps.Examples(data, "test", size=None)
    assert map2aps.Examples(data, "test", size=None, condition="polar").batch([0])[0].shape[2] == 16


def test_a_batch_beyond_all_memory_is_refused_before_any_is_taken(data: Path) -> None:
    settings = {"size": 4096, "mirror": False, "linear": True, "polar": False, "maps": None}
    examples = _native.Examples(data, "train", settings)
    # 51.5 GB.
    with pytest.raises(MemoryError, match="indices: 256 of 50331648 values each"):
        examples.batch([0] * 256)


def test_maps_and_arrays_are_found_by_name(data: Path) -> None:
    dataset = map2aps.Dataset(data)
    assert 0 in dataset and 99 not in dataset and all(one in dataset for one in dataset)
    assert "tx" in dataset[0] and "none" not in dataset[0] and list(dataset[0]) == dataset[0].keys()


def test_examples_are_conditions_and_targets_of_the_labelled_links(data: Path) -> None:
    examples = map2aps.Examples(data, "test", size=16)
    assert repr(examples) == f"Examples({str(data)!r}, 'test': {len(examples)} examples)"
    assert len(examples) == len(examples.links) > 0
    conditions, targets = examples.batch([1, 0, 1])
    assert (conditions.dtype, conditions.shape) == (np.float32, (3, 3, 16, 16))
    assert (targets.dtype, targets.shape) == (np.float32, (3, 180))
    assert np.array_equal(conditions[0], conditions[2]) and np.array_equal(targets[0], targets[2])
    map_id, row, _, _ = examples.links[1]
    linear = map2aps.Examples(data, "test", domain="linear").batch([1])[1][0]
    label = map2aps.Dataset(data)[int(map_id)]["aps_db"][row].astype(float)
    assert np.allclose(linear, 10.0 ** ((label - label.max()) / 10.0), atol=1e-6)
    images = map2aps.Examples(data, "train", size=16).batch(range(4))[0]
    upright = map2aps.Examples(data, "train", size=16, mirror=False)
    assert np.array_equal(images[1], upright.batch([0])[0][0][:, :, ::-1])
    copy = pickle.loads(pickle.dumps(upright))
    assert np.array_equal(copy.links, upright.links)
    with pytest.raises(IndexError, match="indices: 4000 is not from 0 to below"):
        upright.batch([4000])
