use std::fs;
use std::path::Path;

use aps_data::npy::NpyError;
use aps_data::{Dataset, DatasetWriter, Error, Survey};
use serde_json::{Value, json};

use crate::sample;

fn edit(path: &Path, change: impl FnOnce(&str) -> String) {
    let text = fs::read_to_string(path).unwrap();
    let changed = change(&text);
    assert!(text != changed, "the edit found nothing to change");
    fs::write(path, changed).unwrap();
}

#[test]
fn any_flipped_bit_is_found() {
    let root = sample::written();
    let files = sample::contents(root.path());
    // One byte out of many, a bit of its own in each, in every file of the data set.
    for (name, bytes) in files.iter().filter(|(name, _)| name.as_str() != ".lock") {
        let places = (0..bytes.len()).step_by(bytes.len() / 9 + 1);
        for at in places.chain([bytes.len() - 1]) {
            let path = root.path().join(name);
            let mut damaged = bytes.clone();
            damaged[at] ^= 1 << (at % 8);
            fs::write(&path, &damaged).unwrap();
            let problems = Dataset::open(root.path()).map(|dataset| dataset.verify());
            assert!(
                problems.is_err() || !problems.unwrap().is_empty(),
                "{name}, byte {at}"
            );
            fs::write(&path, bytes).unwrap();
        }
    }
    assert!(Dataset::open(root.path()).unwrap().verify().is_empty());
}

#[test]
fn verify_lists_every_damaged_file() {
    let root = sample::written();
    for name in ["map_0001/aps_db.npy", "map_0003/tx.npy"] {
        sample::damage_end(&root.path().join(name));
    }
    fs::remove_file(root.path().join("map_0002/status.npy")).unwrap();
    let problems = Dataset::open(root.path()).unwrap().verify();
    let [
        Error::Checksum { path: a, .. },
        Error::Io { path: b, .. },
        Error::Checksum { path: c, .. },
    ] = &problems[..]
    else {
        panic!("{problems:?}");
    };
    assert!(a.ends_with("map_0001/aps_db.npy"), "{a:?}");
    assert!(b.ends_with("map_0002/status.npy"), "{b:?}");
    assert!(c.ends_with("map_0003/tx.npy"), "{c:?}");
}

#[test]
fn map_that_the_manifest_does_not_name_is_found() {
    let root = sample::written();
    fs::create_dir(root.path().join("map_0007")).unwrap();
    let problems = Dataset::open(root.path()).unwrap().verify();
    assert!(matches!(&problems[..], [Error::Damaged { path, .. }] if path.ends_with("map_0007")));
}

#[test]
fn values_outside_their_range_do_not_leave_the_crate() {
    let cases = [("path_delay_s", -1e-9), ("path_arrival_azimuth_rad", 7.0)];
    for (name, value) in cases {
        let root = sample::written();
        let path = root.path().join(format!("map_0000/{name}.npy"));
        sample::change(&path, 128, &f64::to_le_bytes(value));
        let error = Dataset::open(root.path()).unwrap().paths(0).unwrap_err();
        assert!(error.to_string().contains("number 0 is"), "{error}");
    }
}

#[test]
fn truncated_array_is_an_error_on_loading_and_on_resuming() {
    let root = sample::written();
    let path = root.path().join("map_0001/aps_db.npy");
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 2]).unwrap();
    let error = Dataset::open(root.path()).unwrap().map(1).unwrap_err();
    assert!(
        matches!(
            &error,
            Error::Npy {
                source: NpyError::Length { .. },
                ..
            }
        ),
        "{error:?}"
    );
    assert!(error.to_string().contains("map_0001/aps_db.npy"), "{error}");
    let error = DatasetWriter::open(root.path(), sample::config()).unwrap_err();
    assert!(
        matches!(&error, Error::Damaged { path, .. } if path.ends_with("map_0001/aps_db.npy")),
        "{error:?}"
    );
}

#[test]
fn array_of_another_type_is_refused() {
    let root = sample::written();
    aps_data::npy::write(root.path().join("map_0000/tx.npy"), &[2, 2], &[0.0_f32; 4]).unwrap();
    let error = Dataset::open(root.path()).unwrap().map(0).unwrap_err();
    assert!(
        matches!(
            error,
            Error::Npy {
                source: NpyError::Dtype { .. },
                ..
            }
        ),
        "{error:?}"
    );
}

#[test]
fn values_out_of_range_do_not_leave_the_crate() {
    let cases: [(&str, usize, &[u8]); 6] = [
        ("link_tx", 0, &[9, 0, 0, 0]),
        ("buildings", 3, &[2]),
        ("tx", 0, &f64::NAN.to_le_bytes()),
        ("aps_db", 0, &[0xff, 0x7f]),
        ("aps_max_db", 0, &f32::INFINITY.to_le_bytes()),
        ("status", 1, &[1]),
    ];
    for (name, at, value) in cases {
        let root = sample::written();
        let path = root.path().join(format!("map_0000/{name}.npy"));
        sample::change(&path, 128 + at, value);
        let dataset = Dataset::open(root.path()).unwrap();
        let error = dataset.map(0).unwrap_err();
        assert!(matches!(error, Error::Damaged { .. }), "{name}: {error:?}");
        if name == "aps_db" {
            let error = dataset.spectrum(0, 0).unwrap_err();
            assert!(matches!(error, Error::Damaged { .. }), "{error:?}");
        }
    }
}

#[test]
fn offsets_that_lead_astray_are_refused() {
    for (name, value) in [("path_offset", 99_u64), ("interaction_offset", u64::MAX)] {
        let root = sample::written();
        let path = root.path().join(format!("map_0000/{name}.npy"));
        sample::change(&path, 136, &value.to_le_bytes());
        let error = Dataset::open(root.path()).unwrap().paths(0).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    }
}

#[test]
fn newer_format_is_refused_before_anything_else_is_read() {
    let root = sample::written();
    let path = root.path().join("manifest.json");
    let newer = r#"{"format": "aps-dataset", "format_version": 5, "worlds": []}"#;
    fs::write(&path, newer).unwrap();
    let error = Dataset::open(root.path()).unwrap_err();
    let Error::NewerFormat {
        found, supported, ..
    } = error
    else {
        panic!("{error:?}");
    };
    assert_eq!((found, supported), (5, 4));
    let error = DatasetWriter::open(root.path(), sample::config()).unwrap_err();
    assert!(matches!(error, Error::NewerFormat { .. }), "{error:?}");
}

#[test]
fn older_format_is_read_but_not_continued() {
    let root = sample::written();
    let maps = (0..4).map(|id| format!("map_{id:04}/map.json"));
    for file in maps.chain(["manifest.json".into()]) {
        edit(&root.path().join(file), |text| {
            text.replace("\"format_version\": 4", "\"format_version\": 1")
        });
    }
    let older = Dataset::open(root.path()).unwrap();
    assert_eq!(older.manifest().format_version, 1);
    assert!(older.verify().is_empty(), "{:?}", older.verify());
    let error = DatasetWriter::open(root.path(), sample::config()).unwrap_err();
    assert!(
        matches!(error, Error::OlderFormat { found: 1, .. }),
        "{error:?}"
    );
}

#[test]
fn other_json_is_not_a_data_set() {
    let root = tempfile::tempdir().unwrap();
    for text in [
        "{}",
        r#"{"format": "zarr", "format_version": 1}"#,
        r#"{"format": "aps-dataset", "format_version": 0}"#,
    ] {
        fs::write(root.path().join("manifest.json"), text).unwrap();
        let error = Dataset::open(root.path()).unwrap_err();
        assert!(
            matches!(error, Error::NotADataset { .. }),
            "{text}: {error:?}"
        );
    }
}

#[test]
fn manifest_that_contradicts_itself_is_refused() {
    let cases = [
        (
            "\"valid\": 5",
            "\"valid\": 6",
            "status counts do not add up",
        ),
        (
            "\"name\": \"tx.npy\"",
            "\"name\": \"../../etc/passwd\"",
            "expected tx.npy",
        ),
        ("\"links\": 24", "\"links\": 25", "totals"),
        (
            "\"id\": 3",
            "\"id\": 7",
            "split does not name every map once",
        ),
        ("\"id\": 3", "\"id\": 1", "ascending"),
        (
            "\"paths\": 11",
            "\"paths\": 18446744073709551615",
            "impossible number",
        ),
        ("\"links\": 6", "\"links\": 7", "expected link_tx.npy"),
        ("\"count\": 5", "\"count\": 0", "an axis needs"),
    ];
    for (from, to, message) in cases {
        let root = sample::written();
        edit(&root.path().join("manifest.json"), |text| {
            text.replacen(from, to, 1)
        });
        let error = Dataset::open(root.path()).unwrap_err();
        assert!(
            matches!(&error, Error::Damaged { problem, .. } if problem.contains(message)),
            "{from}: {error}"
        );
    }
}

#[test]
fn configuration_that_is_no_object_is_refused() {
    for other in [json!([1]), json!("label"), json!(5)] {
        let root = sample::written();
        for file in ["manifest.json", "map_0000/map.json"] {
            edit(&root.path().join(file), |text| {
                let mut manifest: Value = serde_json::from_str(text).unwrap();
                manifest["configuration"] = other.clone();
                manifest.to_string()
            });
        }
        let is_told = |error: Error| error.to_string().contains("must be a JSON object");
        assert!(is_told(Dataset::open(root.path()).unwrap_err()));
        fs::remove_file(root.path().join("manifest.json")).unwrap();
        assert!(is_told(Survey::of(root.path()).unwrap_err()));
    }
}

#[test]
fn map_folder_that_cannot_be_listed_is_told() {
    let root = sample::written();
    let dataset = Dataset::open(root.path()).unwrap();
    fs::remove_dir_all(root.path().join("map_0001")).unwrap();
    let told: Vec<String> = dataset.verify().iter().map(Error::to_string).collect();
    assert!(
        told.iter().any(|told| told.starts_with("cannot list")),
        "{told:?}"
    );
}

#[test]
fn folder_without_manifest_says_what_to_do() {
    let root = tempfile::tempdir().unwrap();
    let error = Dataset::open(root.path()).unwrap_err().to_string();
    assert!(error.contains("start it again"), "{error}");
}

#[test]
fn map_and_arrays_that_are_not_there_are_typed_errors() {
    let root = tempfile::tempdir().unwrap();
    let mut config = sample::config();
    config.layout.aps = None;
    DatasetWriter::open(root.path(), config)
        .unwrap()
        .finish(&aps_data::Split::default())
        .unwrap();
    let dataset = Dataset::open(root.path()).unwrap();
    assert!(matches!(
        dataset.map(3),
        Err(Error::UnknownMap { map: 3, .. })
    ));
    let layout = dataset.aps_layout();
    assert!(matches!(layout, Err(Error::NotStored { .. })), "{layout:?}");
}

#[test]
fn parts_of_a_split_are_ascending_whoever_wrote_them() {
    let root = sample::written();
    let path = root.path().join("manifest.json");
    let split = Dataset::open(root.path()).unwrap().manifest().split.clone();
    fs::remove_file(&path).unwrap();
    let mut given = split.clone();
    given.train.reverse();
    assert_ne!(given, split, "two maps are trained on");
    let writer = DatasetWriter::open(root.path(), sample::config()).unwrap();
    assert_eq!(writer.finish(&given).unwrap().split, split);
    // As a program of others may write it.
    let mut manifest: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    manifest["split"]["train"].as_array_mut().unwrap().reverse();
    fs::write(&path, serde_json::to_vec(&manifest).unwrap()).unwrap();
    let dataset = Dataset::open(root.path()).unwrap();
    assert_eq!(dataset.manifest().split, split);
    assert!(!dataset.verify_manifest().is_empty());
}

#[test]
fn maps_with_a_file_cut_short_are_told_without_reading_them() {
    let root = sample::written();
    let dataset = Dataset::open(root.path()).unwrap();
    dataset.check_sizes(&[0, 1]).unwrap();
    let unknown = dataset.check_sizes(&[99]);
    assert!(matches!(unknown, Err(Error::UnknownMap { map: 99, .. })));
    let file = root.path().join("map_0001/status.npy");
    let bytes = fs::read(&file).unwrap();
    fs::write(&file, &bytes[1..]).unwrap();
    dataset.check_sizes(&[0]).unwrap();
    let short = dataset.check_sizes(&[0, 1]);
    assert!(matches!(short, Err(Error::Damaged { path, .. }) if path == file));
}

#[test]
fn foreign_files_are_found() {
    let root = sample::written();
    let dataset = Dataset::open(root.path()).unwrap();
    assert!(dataset.verify().is_empty());
    fs::write(root.path().join("map_0001/extra.npy"), "x").unwrap();
    let problems = dataset.verify();
    assert_eq!(problems.len(), 1);
    let told = problems[0].to_string();
    assert!(told.contains("extra.npy"), "{told}");
}

#[test]
fn manifest_alone_opens_and_finds_no_arrays() {
    let root = sample::written();
    for id in 0..4 {
        fs::remove_dir_all(root.path().join(format!("map_{id:04}"))).unwrap();
    }
    let dataset = Dataset::open(root.path()).unwrap();
    assert!((0..4).all(|id| dataset.map(id).is_err()));
}

#[test]
fn maps_with_more_bytes_than_can_be_counted_are_damaged() {
    let root = sample::written();
    fs::remove_file(root.path().join("manifest.json")).unwrap();
    for id in 0..2 {
        let path = root.path().join(format!("map_{id:04}/map.json"));
        edit(&path, |text| {
            let mut map: Value = serde_json::from_str(text).unwrap();
            map["map"]["tx"] = json!(1_u64 << 59);
            let file = &mut map["map"]["files"][1];
            file["shape"][0] = json!(1_u64 << 59);
            file["bytes"] = json!((1_u64 << 63) + 128);
            map.to_string()
        });
    }
    let error = Survey::of(root.path()).unwrap_err();
    assert!(error.to_string().contains("more bytes than"), "{error}");
}
