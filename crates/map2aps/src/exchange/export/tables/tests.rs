use std::fs::File;
use std::path::Path;

use aps_data::{Dataset, Stored};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, RowAccessor};

use crate::{Control, DatasetPlan, Export, ExportLayout, MapSource};

fn dataset(root: &Path) -> Dataset {
    let plan = DatasetPlan {
        maps: MapSource::Synthetic { count: 4 },
        tx_per_map: 2,
        rx_per_map: 5,
        stored: Stored {
            paths: true,
            pdp: true,
            ..Stored::default()
        },
        ..DatasetPlan::default()
    };
    plan.make(root, &[0, 1, 2, 3], &Control::default()).unwrap();
    Dataset::open(root).unwrap()
}

#[test]
fn a_row_holds_the_link_that_the_data_set_holds() {
    let root = tempfile::tempdir().unwrap();
    let (data, out) = (root.path().join("data"), root.path().join("out"));
    let dataset = dataset(&data);
    let export = Export::new(ExportLayout::Parquet);
    let exported = export.run(&dataset, &out, &Control::default()).unwrap();
    assert_eq!(exported.links, 40);
    for entry in &dataset.manifest().maps {
        let part = dataset.manifest().split.part_of(entry.id);
        let folder = super::columns::folder_of(part);
        let path = out.join(format!("data/{folder}/map_{:04}.parquet", entry.id));
        let file = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
        let (map, paths) = (
            dataset.map(entry.id).unwrap(),
            dataset.paths(entry.id).unwrap(),
        );
        let rows: Vec<_> = file
            .get_row_iter(None)
            .unwrap()
            .map(Result::unwrap)
            .collect();
        assert_eq!(rows.len(), 10);
        for (link, row) in rows.iter().enumerate() {
            let value = |name: &str| {
                let mut columns = row.get_column_iter();
                columns
                    .find(|(column, _)| *column == name)
                    .unwrap()
                    .1
                    .clone()
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
    let root = tempfile::tempdir().unwrap();
    let (data, out) = (root.path().join("data"), root.path().join("out"));
    let dataset = dataset(&data);
    let export = Export::new(ExportLayout::Parquet);
    let first = export.run(&dataset, &out, &Control::default()).unwrap();
    let card = std::fs::read_to_string(out.join("README.md")).unwrap();
    assert!(card.starts_with("---\npretty_name"), "{card}");
    for told in [
        "| `aps_db` | list of float32 | dB |",
        "  - split: train",
        "\"uniform_linear\"",
    ] {
        assert!(card.contains(told), "{told} is not in:\n{card}");
    }
    let croissant = super::read(&out.join("croissant.json"));
    let croissant: serde_json::Value = serde_json::from_slice(&croissant).unwrap();
    assert_eq!(
        croissant["distribution"].as_array().unwrap().len(),
        4 + 1 + 3
    );
    let map = out.join(croissant["distribution"][0]["contentUrl"].as_str().unwrap());
    let whole = super::read(&map);
    // One that was cut off is written anew, the others stay.
    std::fs::write(&map, &whole[..whole.len() / 2]).unwrap();
    let second = export.run(&dataset, &out, &Control::default()).unwrap();
    assert_eq!((super::read(&map), second), (whole, first));
    let other = Export::new(ExportLayout::Samples);
    let refused = other.run(&dataset, &out, &Control::default()).unwrap_err();
    assert!(refused.to_string().contains("another export"), "{refused}");
}

#[test]
fn a_folder_of_others_is_refused_and_stays_as_it_is() {
    let root = tempfile::tempdir().unwrap();
    let (data, out) = (root.path().join("data"), root.path().join("out"));
    let dataset = dataset(&data);
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
    assert_eq!(super::read(&out.join("README.md")), b"mine");
    // A clone of an empty repository has hidden files alone.
    std::fs::rename(out.join("README.md"), out.join(".gitattributes")).unwrap();
    let export = Export::new(ExportLayout::Parquet);
    export.run(&dataset, &out, &Control::default()).unwrap();
    assert_eq!(super::read(&out.join(".gitattributes")), b"mine");
}

#[test]
fn tables_that_a_larger_export_of_a_map_left_are_removed() {
    let root = tempfile::tempdir().unwrap();
    let (data, out) = (root.path().join("data"), root.path().join("out"));
    let dataset = dataset(&data);
    let export = Export {
        maps: Some(vec![0, 1]),
        ..Export::new(ExportLayout::Parquet)
    };
    export.run(&dataset, &out, &Control::default()).unwrap();
    let part = dataset.manifest().split.part_of(0);
    let own = out.join("data").join(super::columns::folder_of(part));
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
fn a_limit_leaves_links_out_and_maps_with_none_have_an_empty_table() {
    let root = tempfile::tempdir().unwrap();
    let (data, out) = (root.path().join("data"), root.path().join("out"));
    let dataset = dataset(&data);
    let table = |id: u32| {
        let part = dataset.manifest().split.part_of(id);
        let folder = super::columns::folder_of(part);
        let path = out.join(format!("data/{folder}/map_{id:04}.parquet"));
        SerializedFileReader::new(File::open(path).unwrap()).unwrap()
    };
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
            let file = table(entry.id);
            let metadata = file.metadata().file_metadata();
            rows += metadata.num_rows();
            columns.push(metadata.schema_descr().num_columns());
        }
        assert_eq!(rows, expected as i64);
        assert!(columns[0] > 10 && columns.iter().all(|&count| count == columns[0]));
    }
}
