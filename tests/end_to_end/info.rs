//! `info`: the contents of a folder, finished or not.

use std::fs;

use aps_data::{Dataset, Part};
use serde_json::Value;

use crate::folder::Folder;
use crate::metrics::{linear, mean_std};
use crate::{assert_told, fail, succeed};

const SETTINGS: &str = "--maps synthetic:3 --profile smoke --store aps,paths";

fn json(folder: &Folder) -> Value {
    serde_json::from_str(&succeed(&format!("info {} --json", folder.arg("data")))).unwrap()
}

#[test]
fn finished_data_set_is_described() {
    let folder = Folder::new();
    folder.make("data", &[SETTINGS]);
    let told = succeed(&format!("info {}", folder.arg("data")));
    let parts = [
        "data', finished",
        "0-2",
        "240  4 transmitters, receivers from 80 points a map",
        "180 bins over [-180, 180) deg, dB in half precision",
        "paths: delay",
        "label.protocol = \"paper\"",
        "trace.max_reflections = 5",
        "seed = 42",
        "training maps: mean 0.",
        "dominant peaks:",
    ];
    assert_told(&told, &parts);
    assert!(!told.contains("to continue"), "{told}");
    let json = json(&folder);
    assert_eq!(json["links"], 240);
    assert_eq!(json["finished"], true);
    assert_eq!(json["configuration"]["label"]["protocol"], "paper");
    let status = json["status"].as_object().unwrap().values();
    assert_eq!(status.map(|n| n.as_u64().unwrap()).sum::<u64>(), 240);
}

#[test]
fn statistics_are_those_that_metrics_normalises_by() {
    let folder = Folder::new();
    folder.make("data", &[SETTINGS]);
    let json = json(&folder);
    let of_info = |name: &str| json["training_relative_power"][name].as_f64().unwrap();
    let dataset = Dataset::open(folder.path("data")).unwrap();
    let (mean, std) = mean_std(&linear(&dataset, Part::Train));
    assert!((of_info("mean") - mean).abs() < 1e-12);
    assert!((of_info("std") - std).abs() < 1e-12);
}

#[test]
fn unfinished_data_set_tells_what_it_lacks_and_how_to_go_on() {
    let folder = Folder::new();
    folder.make("data", &[SETTINGS]);
    fs::rename(folder.path("data"), folder.path("whole")).unwrap();
    folder.make("data", &[SETTINGS, "--shard 1/3 --threads 1"]);
    let json = json(&folder);
    assert_eq!(json["missing_maps"], serde_json::json!([1, 2]));
    let told = succeed(&format!("info {}", folder.arg("data")));
    assert_told(&told, &["unfinished: 2 of 3 maps are missing"]);
    let command = told
        .lines()
        .find_map(|line| line.trim().strip_prefix("cargo xtask "));
    succeed(command.unwrap());
    folder.assert_same("whole", "data");
}

#[test]
fn folder_without_a_data_set_is_told() {
    let (folder, maps) = Folder::with_maps(1);
    assert!(fail(&format!("info {maps}")).contains("neither a manifest nor a map"));
    assert!(fail(&format!("info {}", folder.arg("nothing"))).contains("No such file"));
}
