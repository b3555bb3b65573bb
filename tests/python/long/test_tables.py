"""Exported tables, as their readers see them."""

import json
import subprocess
from pathlib import Path

import datasets
import mlcroissant
import numpy as np
import pandas as pd
import polars as pl
import pytest
from huggingface_hub import DatasetCard

import map2aps
from pages import ROOT


@pytest.fixture(scope="module")
def tables(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("tables")
    command = ["cargo", "run", "--quiet", "--package", "xtask", "--", "export", str(data), "--layout", "parquet", "--out", str(out)]
    subprocess.run(command, cwd=ROOT, check=True)
    return out


def rows_of(dataset: map2aps.Dataset, map_id: int) -> np.ndarray:
    return np.asarray(dataset[map_id]["aps_db"]).astype(np.float32)


def test_pandas_reads_the_links_of_a_map(data: Path, tables: Path) -> None:
    dataset = map2aps.Dataset(data)
    for part, folder in (("train", "train"), ("develop", "develop"), ("test", "test")):
        for map_id in dataset.split(part):
            table = pd.read_parquet(tables / "data" / folder / f"map_{map_id:04}.parquet")
            one = dataset[map_id]
            assert len(table) == one.links and (table["map"] == map_id).all() and (table["status"] == "valid").all()
            assert np.array_equal(np.stack(table["aps_db"]), rows_of(dataset, map_id))
            assert np.array_equal(table["aps_max_db"], one["aps_max_db"])
            assert np.array_equal(table[["tx_x_m", "tx_y_m"]], one["tx"][one["link_tx"]])
            assert np.array_equal(np.concatenate(table["path_delay_s"].to_list()), one["path_delay_s"])
            gain = np.concatenate(table["path_gain_re"].to_list()) + 1j * np.concatenate(table["path_gain_im"].to_list())
            assert np.array_equal(gain, one["path_gain"])
    buildings = pd.read_parquet(tables / "buildings.parquet").set_index("map")
    pixels = np.frombuffer(buildings.loc[2, "pixels"], np.uint8).reshape(256, 256)
    assert np.array_equal(pixels, dataset[2]["buildings"])


def test_polars_reads_all_maps_at_once(data: Path, tables: Path) -> None:
    table = pl.read_parquet(tables / "data" / "*" / "*.parquet")
    assert len(table) == map2aps.Dataset(data).links
    assert table["map"].unique().sort().to_list() == list(range(6))


def test_datasets_loads_files_and_the_folder_with_its_card(data: Path, tables: Path, tmp_path: Path) -> None:
    dataset = map2aps.Dataset(data)
    files = {"train": str(tables / "data" / "train" / "*.parquet"), "test": str(tables / "data" / "test" / "*.parquet")}
    loaded = datasets.load_dataset("parquet", data_files=files, cache_dir=str(tmp_path / "files"))
    assert loaded["train"].num_rows == 12 * len(dataset.split("train"))
    folder = datasets.load_dataset(str(tables), cache_dir=str(tmp_path / "folder"))
    assert {name: part.num_rows for name, part in folder.items()} == {
        "train": 12 * len(dataset.split("train")),
        "validation": 12 * len(dataset.split("develop")),
        "test": 12 * len(dataset.split("test")),
    }
    first = folder["test"][0]
    assert np.array_equal(np.array(first["aps_db"], np.float32), rows_of(dataset, first["map"])[first["link"]])


def test_the_description_names_every_file_and_column_and_is_read(data: Path, tables: Path) -> None:
    croissant = json.loads((tables / "croissant.json").read_text())
    files = {entry["contentUrl"] for entry in croissant["distribution"] if entry["@type"] == "cr:FileObject"}
    assert files == {str(file.relative_to(tables)) for file in tables.rglob("*.parquet")}
    sets = {records["@id"]: records["field"] for records in croissant["recordSet"]}
    columns = {name: {field["source"]["extract"]["column"] for field in fields} for name, fields in sets.items()}
    description = mlcroissant.Dataset(tables / "croissant.json")
    records = list(description.records("links-test"))
    dataset = map2aps.Dataset(data)
    assert len(records) == 12 * len(dataset.split("test"))
    first = {name.rpartition("/")[2]: value for name, value in records[0].items()}
    assert np.array_equal(np.array(first["aps_db"], np.float32), rows_of(dataset, first["map"])[first["link"]])
    of_links = set(pd.read_parquet(next((tables / "data" / "train").glob("*.parquet"))).columns)
    of_buildings = set(pd.read_parquet(tables / "buildings.parquet").columns)
    assert columns == {**dict.fromkeys(("links-train", "links-validation", "links-test"), of_links), "buildings": of_buildings}
    maps = {record["buildings/map"]: record["buildings/pixels"] for record in description.records("buildings")}
    assert sorted(maps) == list(range(6))
    assert np.array_equal(np.frombuffer(maps[3], np.uint8).reshape(256, 256), dataset[3]["buildings"])
    assert description.metadata.cite_as.startswith("@misc{") and description.metadata.creators[0].name
    # The only thing that the format's own check misses is what nobody knows yet.
    issues = description.metadata.ctx.issues
    assert not issues.errors and [issue for issue in issues.warnings if "datePublished" not in str(issue)] == []


def test_the_card_is_one_that_hubs_read(data: Path, tables: Path) -> None:
    card = DatasetCard.load(tables / "README.md")
    about = card.data.to_dict()
    assert (about["license"], about["license_name"]) == ("other", "licence-of-the-maps")
    assert (about["size_categories"], about["task_categories"]) == (["n<1K"], ["tabular-regression"])
    assert [config["config_name"] for config in about["configs"]] == ["links", "buildings"]
    dataset = map2aps.Dataset(data)
    for part, split in (("train", "train"), ("develop", "validation"), ("test", "test")):
        maps = len(dataset.split(part))
        assert f"| {split} | {maps} | {12 * maps} | {maps} |" in card.text
    for title in ("Splits", "Columns", "How it was made", "Licence", "Citation"):
        assert f"\n## {title}\n" in card.text
    assert "```bibtex\n@misc{" in card.text and "| `metres_per_pixel` | float64 | m |" in card.text


def test_an_export_of_some_links_loads_too(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "some"
    command = ["cargo", "run", "--quiet", "--package", "xtask", "--", "export", str(data), "--layout", "parquet", "--out", str(out), "--limit", "20"]
    subprocess.run(command, cwd=ROOT, check=True)
    folder = datasets.load_dataset(str(out), cache_dir=str(tmp_path / "cache"))
    assert sum(part.num_rows for part in folder.values()) == 20
    mlcroissant.Dataset(jsonld=str(out / "croissant.json"))
