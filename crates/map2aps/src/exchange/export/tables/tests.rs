use std::fs::{File, read};
use std::path::{Path, PathBuf};

use aps_data::{Dataset, Part, Stored};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, RowAccessor};
use serde_json::Value;
use tempfile::TempDir;

use super::columns::{Column, Values};
use super::{Table, create_folder, export_within};
use crate::{Control, DatasetPlan, Export, ExportLayout, synthetic};

/// A data set in a folder, and the place beside it where it is exported to.
fn setting() -> (TempDir, Dataset, PathBuf) {
    let root = tempfile::tempdir().unwrap();
    let (data, out) = (root.path().join("data"), root.path().join("out"));
    let plan = DatasetPlan {
        stored: Stored {
            paths: true,
            pdp: true,
            ..Stored::default()
        },
        ..synthetic::plan(4, 2, 5)
    };
    let dataset = synthetic::made(&plan, &data, &[0, 1, 2, 3]);
    (root, dataset, out)
}

/// Folder of the tables of a map in an export.
fn folder_of(dataset: &Dataset, out: &Path, id: u32) -> PathBuf {
    let part = dataset.manifest().split.part_of(id);
    out.join("data").join(super::columns::folder_of(part))
}

fn open(folder: &Path, name: &str) -> Option<SerializedFileReader<File>> {
    let file = File::open(folder.join(name)).ok()?;
    Some(SerializedFileReader::new(file).unwrap())
}

#[test]
fn a_row_holds_the_link_that_the_data_set_holds() {
    let (_root, dataset, out) = setting();
    let export = Export::new(ExportLayout::Parquet);
    let exported = export.run(&dataset, &out, &Control::default()).unwrap();
    assert_eq!(exported.links, 40);
    for entry in &dataset.manifest().maps {
        let id = entry.id;
        let folder = folder_of(&dataset, &out, id);
        let file = open(&folder, &format!("map_{id:04}.parquet")).unwrap();
        let (map, paths) = (dataset.map(id).unwrap(), dataset.paths(id).unwrap());
        let rows = file.get_row_iter(None).unwrap().map(Result::unwrap);
        let rows: Vec<_> = rows.collect();
        assert_eq!(rows.len(), 10);
        for (link, row) in rows.iter().enumerate() {
            let value = |name: &str| {
                let mut columns = row.get_column_iter();
                let found = columns.find(|(column, _)| *column == name);
                found.unwrap().1.clone()
            };
            let list = |name: &str| match value(name) {
                Field::ListInternal(list) => list.elements().to_vec(),
                other => panic!("{other}"),
            };
            assert_eq!(row.get_int(0).unwrap() as u32, map.id);
            assert_eq!(value("rx"), Field::Int(map.links[link][1] as i32));
            assert_eq!(value("rx_y_m"), Field::Double(map.ends_m(link).1[1]));
            assert_eq!(value("status"), Field::Str("valid".into()));
            let aps = map.aps.as_ref().unwrap();
            let mut db = vec![0.0; 180];
            aps.read_relative_db(link, &mut db);
            let db: Vec<Field> = db.into_iter().map(Field::Float).collect();
            assert_eq!(list("aps_db"), db);
            assert_eq!(value("aps_max_db"), Field::Float(aps.max_db()[link]));
            let gains = paths
                .paths_of(link)
                .map(|path| Field::Double(paths.gain[path][1]));
            assert_eq!(list("path_gain_im"), gains.collect::<Vec<_>>());
            assert_eq!(list("pdp_db").len(), 128);
        }
    }
}

#[test]
fn an_export_is_kept_and_described_and_another_is_refused() {
    let (root, dataset, out) = setting();
    let export = Export::new(ExportLayout::Parquet);
    let first = export.run(&dataset, &out, &Control::default()).unwrap();
    let card = std::fs::read_to_string(out.join("README.md")).unwrap();
    assert!(card.starts_with("---\npretty_name"), "{card}");
    let croissant = read(out.join("croissant.json")).unwrap();
    let croissant: Value = serde_json::from_slice(&croissant).unwrap();
    let files = croissant["distribution"].as_array().unwrap();
    assert_eq!(files.len(), 4 + 1 + 3);
    let records = croissant["recordSet"].as_array().unwrap();
    let ids = records.iter().map(|set| set["@id"].as_str().unwrap());
    let expected = ["links-train", "links-validation", "links-test", "buildings"];
    assert_eq!(ids.collect::<Vec<_>>(), expected);
    let of_buildings = records[3]["field"].as_array().unwrap();
    fn source(field: &Value) -> &str {
        assert_eq!(field["source"]["fileObject"]["@id"], "buildings.parquet");
        field["source"]["extract"]["column"].as_str().unwrap()
    }
    let columns: Vec<&str> = of_buildings.iter().map(source).collect();
    let columns = columns.join(" ");
    assert_eq!(columns, "map split height width metres_per_pixel pixels");
    let told = |set: usize, name: &str| {
        let fields = records[set]["field"].as_array().unwrap();
        let ends = |field: &&Value| {
            let id = field["@id"].as_str().unwrap();
            id.rsplit('/').next() == Some(name)
        };
        let field = fields.iter().find(ends).unwrap();
        field["description"].as_str().unwrap().to_owned()
    };
    for (set, name, unit) in [
        (0, "aps_db", " [dB]"),
        (0, "path_delay_s", " [s]"),
        (1, "path_arrival_azimuth_rad", " [rad]"),
        (2, "tx_x_m", " [m]"),
        (3, "metres_per_pixel", " [m]"),
    ] {
        let told = told(set, name);
        assert!(told.ends_with(unit), "{told}");
    }
    assert_eq!(croissant["citeAs"], super::card::CITATION);
    assert_eq!(croissant["license"], super::card::LICENCE);
    assert_eq!(croissant["creator"]["@type"], "sc:Organization");
    // Nobody told when it is published.
    assert_eq!(croissant.get("datePublished"), None);
    let map = out.join(croissant["distribution"][0]["contentUrl"].as_str().unwrap());
    let whole = read(&map).unwrap();
    // One that was cut off is written anew, the others stay.
    std::fs::write(&map, &whole[..whole.len() / 2]).unwrap();
    let second = export.run(&dataset, &out, &Control::default()).unwrap();
    assert_eq!((read(&map).unwrap(), second), (whole, first));
    let other = root.path().join("again");
    export.run(&dataset, &other, &Control::default()).unwrap();
    for file in ["README.md", "croissant.json", "buildings.parquet"] {
        assert_eq!(
            read(other.join(file)).unwrap(),
            read(out.join(file)).unwrap()
        );
    }
    let other = Export::new(ExportLayout::Samples);
    let refused = other.run(&dataset, &out, &Control::default()).unwrap_err();
    assert!(refused.to_string().contains("another export"), "{refused}");
}

#[test]
fn the_card_tells_parts_columns_making_licence_and_citation() {
    let (_root, dataset, out) = setting();
    let export = Export::new(ExportLayout::Parquet);
    export.run(&dataset, &out, &Control::default()).unwrap();
    let card = std::fs::read_to_string(out.join("README.md")).unwrap();
    let (header, text) = card[4..].split_once("\n---\n").unwrap();
    for told in [
        "license: other\nlicense_name: licence-of-the-maps\n",
        "size_categories:\n- n<1K\n",
        "task_categories:\n- tabular-regression\n",
        "  - split: train\n    path: data/train/*.parquet\n",
        "- config_name: buildings\n  data_files: buildings.parquet",
    ] {
        assert!(header.contains(told), "{told} is not in:\n{header}");
    }
    let bytes = |folder: &str| {
        let files = std::fs::read_dir(out.join("data").join(folder)).unwrap();
        let size = |file: std::io::Result<std::fs::DirEntry>| file.unwrap().metadata().unwrap();
        files.map(|file| size(file).len()).sum::<u64>()
    };
    // Ten links a map, and one file.
    for (part, folder, split) in [
        (Part::Train, "train", "train"),
        (Part::Develop, "develop", "validation"),
        (Part::Test, "test", "test"),
    ] {
        let maps = dataset.manifest().split.maps(part).len();
        let row = format!(
            "\n| {split} | {maps} | {} | {maps} | {} |\n",
            10 * maps,
            bytes(folder)
        );
        assert!(text.contains(&row), "{row} is not in:\n{text}");
    }
    for told in [
        "| `aps_db` | list of float32 | dB |",
        "| `path_delay_s` | list of float64 | s |",
        "| `rx_y_m` | float64 | m |",
        "| `metres_per_pixel` | float64 | m |",
        "| `pixels` | binary |  |",
        "`aps_db` has 180 bins, from -180 to 180 deg",
        "Maps: \"synthetic\". Carrier: 3500000000.0 Hz. At most 5 reflections, 2 diffractions and 7 interactions",
        "Seed: 42.",
        "\"uniform_linear\"",
        "\n## Licence\n",
        "`license_link`",
        super::card::CITATION,
        "Junxi Huang and Xiucheng Wang and Nan Cheng",
    ] {
        assert!(text.contains(told), "{told} is not in:\n{text}");
    }
    let order = "Splits, Columns, How it was made, Licence, Citation".split(", ");
    let places = order.map(|title| text.find(&format!("\n## {title}\n")));
    let places: Vec<_> = places.collect();
    assert!(places.is_sorted() && places[0].is_some(), "{places:?}");
}

/// Bytes of the numbers of some columns, and of their texts as Parquet stores them.
fn size_of(columns: &[Column]) -> usize {
    let size = |column: &Column| match &column.values {
        Values::Integers(values) => 4 * values.len(),
        Values::Floats(values) | Values::FloatLists(values, _) => 4 * values.len(),
        Values::Doubles(values) | Values::DoubleLists(values, _) => 8 * values.len(),
        Values::Texts(values) => values.iter().map(|text| 4 + text.len()).sum(),
        Values::Bytes(values) => values.iter().map(|bytes| 4 + bytes.len()).sum(),
    };
    columns.iter().map(size).sum()
}

#[test]
fn a_map_beyond_the_bound_of_a_file_goes_into_several() {
    let (_root, dataset, out) = setting();
    let table = Table {
        map: dataset.map(0).unwrap(),
        pdp: Some(dataset.pdp(0).unwrap()),
        paths: Some(dataset.paths(0).unwrap()),
    };
    let size = |rows: std::ops::Range<usize>| size_of(&table.columns(rows));
    let largest = (0..10).map(|row| size(row..row + 1)).max().unwrap();
    for bound in [1, largest + 100, 3 * largest, size(0..10) / 2, usize::MAX] {
        let portions = table.portions(10, bound);
        // All rows once, in their order; of several in a file none is beyond the bound.
        let rows: Vec<usize> = portions.iter().cloned().flatten().collect();
        assert_eq!(rows, (0..10).collect::<Vec<_>>(), "{bound}");
        let fits = |rows: &std::ops::Range<usize>| rows.len() == 1 || size(rows.clone()) <= bound;
        assert!(portions.iter().all(fits), "{bound}: {portions:?}");
        assert_eq!(
            portions.len() == 1,
            bound == usize::MAX,
            "{bound}: {portions:?}"
        );
    }
    assert_eq!(table.portions(10, 1).len(), 10);
    assert!(table.portions(0, 1).is_empty());

    create_folder(&out).unwrap();
    let (ids, control) = ([0, 1, 2, 3], Control::default());
    export_within(3 * largest, None, &ids, &dataset, &out, &control).unwrap();
    let folder = folder_of(&dataset, &out, 0);
    let mut rows = 0;
    for number in 0..table.portions(10, 3 * largest).len() {
        let name = match number {
            0 => "map_0000.parquet".to_owned(),
            _ => format!("map_0000-{number}.parquet"),
        };
        let file = open(&folder, &name).unwrap();
        rows += file.metadata().file_metadata().num_rows();
    }
    assert_eq!(rows, 10);
}

#[test]
fn a_folder_of_others_is_refused_and_stays_as_it_is() {
    let (_root, dataset, out) = setting();
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("README.md"), "mine").unwrap();
    for layout in [ExportLayout::Parquet, ExportLayout::Released] {
        let refused = Export::new(layout).run(&dataset, &out, &Control::default());
        let text = refused.unwrap_err().to_string();
        assert!(text.contains("holds other files"), "{text}");
    }
    let names = || {
        let entries = std::fs::read_dir(&out).unwrap();
        entries.map(|entry| entry.unwrap().file_name())
    };
    assert_eq!(names().collect::<Vec<_>>(), ["README.md"]);
    assert_eq!(read(out.join("README.md")).unwrap(), b"mine");
    // A clone of an empty repository has hidden files alone.
    std::fs::rename(out.join("README.md"), out.join(".gitattributes")).unwrap();
    let export = Export::new(ExportLayout::Parquet);
    export.run(&dataset, &out, &Control::default()).unwrap();
    assert_eq!(read(out.join(".gitattributes")).unwrap(), b"mine");
}

#[test]
fn tables_that_a_larger_export_of_a_map_left_are_removed() {
    let (_root, dataset, out) = setting();
    let export = Export {
        maps: Some(vec![0, 1]),
        ..Export::new(ExportLayout::Parquet)
    };
    export.run(&dataset, &out, &Control::default()).unwrap();
    let own = folder_of(&dataset, &out, 0);
    std::fs::create_dir_all(out.join("data/other")).unwrap();
    let of_map = [
        own.join("map_0000-1.parquet"),
        own.join("map_0000-12.parquet"),
    ];
    let moved = out.join("data/other/map_0001.parquet");
    let kept = [own.join("map_0002.parquet"), own.join("map_0000.csv")];
    for path in of_map.iter().chain([&moved]).chain(&kept) {
        std::fs::write(path, "rows").unwrap();
    }
    export.run(&dataset, &out, &Control::default()).unwrap();
    assert!(of_map.iter().chain([&moved]).all(|path| !path.exists()));
    assert!(kept.iter().all(|path| path.exists()));
    assert!(own.join("map_0000.parquet").exists());
}

#[test]
fn a_limit_leaves_links_out_and_maps_with_none_have_no_table() {
    let (_root, dataset, out) = setting();
    // A file of another limit is made anew.
    for (limit, expected) in [(Some(13), 13), (None, 40), (Some(0), 0)] {
        let export = Export {
            limit,
            ..Export::new(ExportLayout::Parquet)
        };
        let exported = export.run(&dataset, &out, &Control::default()).unwrap();
        assert_eq!(exported.links, expected);
        let (mut rows, mut columns) = (0, Vec::new());
        for entry in &dataset.manifest().maps {
            // Readers of a folder take no file without rows.
            let folder = folder_of(&dataset, &out, entry.id);
            let Some(file) = open(&folder, &format!("map_{:04}.parquet", entry.id)) else {
                continue;
            };
            let metadata = file.metadata().file_metadata();
            assert!(metadata.num_rows() > 0);
            rows += metadata.num_rows();
            columns.push(metadata.schema_descr().num_columns());
        }
        assert_eq!(rows, expected as i64);
        let is_whole = |&count: &usize| count > 10 && count == columns[0];
        assert!(columns.iter().all(is_whole));
        assert_eq!(columns.is_empty(), expected == 0);
    }
}

#[test]
fn tables_of_other_maps_are_not_put_beside_them() {
    let (_root, dataset, out) = setting();
    let export = |maps: [u32; 2]| {
        let export = Export {
            maps: Some(maps.to_vec()),
            ..Export::new(ExportLayout::Parquet)
        };
        export.run(&dataset, &out, &Control::default())
    };
    let first = export([0, 1]).unwrap();
    assert_eq!(export([1, 0]).unwrap(), first);
    let refused = export([2, 3]).unwrap_err().to_string();
    assert!(refused.contains("of another export"), "{refused}");
}

#[test]
fn an_export_is_brought_up_to_date_when_its_data_set_has_grown() {
    let root = tempfile::tempdir().unwrap();
    let [data, out] = ["data", "out"].map(|name| root.path().join(name));
    let run =
        |export: &Export| export.run(&Dataset::open(&data).unwrap(), &out, &Control::default());
    let grown = |maps: &[u32]| {
        synthetic::made(&synthetic::plan(4, 1, 2), &data, maps);
        run(&Export::new(ExportLayout::Parquet)).unwrap().links
    };
    assert_eq!([grown(&[0, 1]), grown(&[0, 1, 2])], [4, 6]);
    let of_part = Export {
        part: Some(Part::Train),
        ..Export::new(ExportLayout::Parquet)
    };
    let refused = run(&of_part).unwrap_err().to_string();
    assert!(refused.contains("of another export"), "{refused}");
    assert_eq!(grown(&[0, 1, 2, 3]), 8);
    assert!(run(&Export::new(ExportLayout::Samples)).is_err());
}

#[test]
fn the_split_of_the_buildings_is_that_of_the_data_set() {
    let (_root, dataset, out) = setting();
    let export = Export::new(ExportLayout::Parquet);
    export.run(&dataset, &out, &Control::default()).unwrap();
    let path = out.join("buildings.parquet");
    let whole = read(&path).unwrap();
    // As many rows as there are maps.
    let rows = vec![Column {
        name: "map",
        unit: "",
        meaning: "",
        values: Values::Integers(vec![0; 4]),
    }];
    std::fs::write(
        &path,
        super::file::bytes("map", std::iter::once(rows)).unwrap(),
    )
    .unwrap();
    export.run(&dataset, &out, &Control::default()).unwrap();
    assert_eq!(read(&path).unwrap(), whole);
}

#[test]
fn a_map_whose_number_has_no_room_is_refused() {
    let (_root, dataset, out) = setting();
    let control = Control::default();
    let refused = super::export(None, &[1 << 31], &dataset, &out, &control).unwrap_err();
    assert!(
        refused
            .to_string()
            .starts_with("map 2147483648: the tables"),
        "{refused}"
    );
}
