//! `info`: the contents of a folder, finished or not.

use std::fs;

use serde_json::Value;

use crate::folder::{Folder, assert_same, files};
use crate::{fail, succeed};

const SETTINGS: &str = "--maps synthetic:3 --profile smoke --store aps,paths";

fn json(folder: &Folder) -> Value {
    serde_json::from_str(&succeed(&format!("info {} --json", folder.arg("data")))).unwrap()
}

#[test]
fn finished_data_set_is_described() {
    let folder = Folder::new();
    folder.make("data", &[SETTINGS]);
    let told = succeed(&format!("info {}", folder.arg("data")));
    for part in [
        "data', finished",
        "0-2",
        "240  4 transmitters, receivers from 80 points a map",
        "180 bins over [-180, 180] deg, dB in half precision",
        "paths: delay",
        "label.protocol = \"released\"",
        "trace.max_reflections = 2",
        "seed = 42",
        "training maps: mean 0.",
        "dominant peaks:",
    ] {
        assert!(told.contains(part), "'{part}' is not in\n{told}");
    }
    assert!(!told.contains("to continue"), "{told}");
    let json = json(&folder);
    assert_eq!(json["links"], 240);
    assert_eq!(json["finished"], true);
    assert_eq!(json["configuration"]["label"]["protocol"], "released");
    let counted: u64 = json["status"]
        .as_object()
        .unwrap()
        .values()
        .map(|n| n.as_u64().unwrap())
        .sum();
    assert_eq!(counted, 240);
}

#[test]
fn statistics_are_those_that_metrics_normalises_by() {
    let folder = Folder::new();
    folder.make("data", &[SETTINGS]);
    let json = json(&folder);
    let of_info = |name: &str| json["training_relative_power"][name].as_f64().unwrap();
    let dataset = aps_data::Dataset::open(folder.path("data")).unwrap();
    let mut values = Vec::new();
    for map in dataset.maps_of(aps_data::Part::Train) {
        let map = map.unwrap();
        let aps = map.aps.as_ref().unwrap();
        let mut row = vec![0.0; aps.bins()];
        for link in map.valid_links() {
            aps.read_relative_db(link, &mut row);
            values.extend(row.iter().map(|&db| 10_f64.powf(f64::from(db) / 10.0)));
        }
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n;
    assert!((of_info("mean") - mean).abs() < 1e-12);
    assert!((of_info("std") - variance.sqrt()).abs() < 1e-12);
}

#[test]
fn unfinished_data_set_tells_what_it_lacks_and_how_to_go_on() {
    let folder = Folder::new();
    folder.make("data", &[SETTINGS]);
    let expected = files(&folder.path("data"));
    fs::remove_dir_all(folder.path("data")).unwrap();
    folder.make("data", &[SETTINGS, "--shard 1/3 --threads 1"]);
    let json = json(&folder);
    assert_eq!(json["missing_maps"], serde_json::json!([1, 2]));
    let told = succeed(&format!("info {}", folder.arg("data")));
    assert!(
        told.contains("unfinished: 2 of 3 maps are missing"),
        "{told}"
    );
    let command = told
        .lines()
        .find_map(|line| line.trim().strip_prefix("cargo xtask "));
    succeed(command.unwrap());
    assert_same(&expected, &files(&folder.path("data")));
}

#[test]
fn folder_without_a_data_set_is_told() {
    let folder = Folder::new();
    let maps = folder.maps(1);
    assert!(fail(&format!("info {maps}")).contains("neither a manifest nor a map"));
    assert!(fail(&format!("info {}", folder.arg("nothing"))).contains("No such file"));
}
