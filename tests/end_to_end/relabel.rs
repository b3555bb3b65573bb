//! `relabel`: other labels from stored paths, the same that a fresh trace would get.

use std::collections::BTreeMap;

use aps_data::Dataset;
use aps_label::{Array, LabelConfig, Labeler, PathSample};
use half::f16;

use crate::folder::{Folder, assert_same, files};
use crate::{assert_told, fail, succeed};

const SETTINGS: &str = "--maps synthetic:3 --profile smoke --threads 1 --store";

fn relabel(folder: &Folder, from: &str, out: &str, more: &str) {
    let [from, out] = [from, out].map(|name| folder.arg(name));
    succeed(&format!("relabel {from} --out {out} {more}"));
}

fn arrays(folder: &Folder, name: &str) -> BTreeMap<String, Vec<u8>> {
    let mut files = files(&folder.path(name));
    files.retain(|name, _| name.ends_with(".npy"));
    files
}

#[test]
fn same_settings_give_the_same_bytes() {
    let folder = Folder::new();
    folder.make("traced", &[SETTINGS, "aps,pdp,paths"]);
    relabel(&folder, "traced", "same", "--threads 2");
    folder.assert_same("traced", "same");
}

#[test]
fn other_protocol_gives_the_labels_of_a_fresh_trace_and_back() {
    let folder = Folder::new();
    folder.make("released", &[SETTINGS, "aps,paths --protocol released"]);
    folder.make("paper", &[SETTINGS, "aps,pdp,paths"]);
    let to_paper = "--protocol paper --store aps,pdp,paths";
    relabel(&folder, "released", "relabelled", to_paper);
    assert_same(&arrays(&folder, "paper"), &arrays(&folder, "relabelled"));
    let back = "--protocol released --store aps,paths";
    relabel(&folder, "relabelled", "back", back);
    assert_same(&arrays(&folder, "released"), &arrays(&folder, "back"));
    succeed(&format!("verify {} --sample 40", folder.arg("relabelled")));
}

#[test]
fn circular_array_sees_what_the_crate_computes() {
    let folder = Folder::new();
    folder.make("traced", &[SETTINGS, "aps,paths"]);
    let array = "--protocol released --array uca --elements 12 --spacing 0.4 --fs-hz 1e8";
    let more = "--delay-points 65 --last-delay-s 2e-6 --store aps";
    relabel(&folder, "traced", "uca", &format!("{array} {more}"));
    // A trace makes such labels at once.
    relabel(&folder, "traced", "later", &format!("{array} --store aps"));
    folder.make("at-once", &[SETTINGS, "aps", array]);
    let spectra = |data| std::fs::read(folder.path(data).join("map_0000/aps_db.npy")).unwrap();
    assert!(spectra("at-once") == spectra("later"));

    let mut config = LabelConfig {
        sampling_rate_hz: 1e8,
        array: Array::UniformCircular {
            elements: 12,
            radius_wavelengths: 12.0 * 0.4 / std::f64::consts::TAU,
        },
        ..LabelConfig::released()
    };
    (config.delay_axis.points, config.delay_axis.last_s) = (65, 2e-6);
    let labeler = Labeler::new(&config).unwrap();

    let traced = Dataset::open(folder.path("traced")).unwrap();
    let uca = Dataset::open(folder.path("uca")).unwrap();
    assert!(!uca.manifest().layout.paths);
    assert_eq!(uca.manifest().split, traced.manifest().split);
    let mut checked = 0;
    for id in 0..3 {
        let (map, paths) = (uca.map(id).unwrap(), traced.paths(id).unwrap());
        let aps = map.aps.as_ref().unwrap();
        let mut row = vec![0.0; aps.bins()];
        for link in map.valid_links() {
            let samples: Vec<PathSample> = paths
                .paths_of(link)
                .map(|path| PathSample {
                    delay_s: paths.delay_s[path],
                    arrival_azimuth_rad: paths.arrival_azimuth_rad[path],
                    gain_db: 20.0 * paths.gain[path][0].hypot(paths.gain[path][1]).log10(),
                })
                .collect();
            let label = labeler.label(&samples).unwrap().unwrap();
            let top = label.aps_db.iter().copied().fold(f64::MIN, f64::max);
            aps.read_relative_db(link, &mut row);
            for (&stored, &db) in row.iter().zip(&label.aps_db) {
                let error = f64::from(stored) - (db - top);
                let step = f64::from(f16::EPSILON) * (db - top).abs();
                assert!(
                    error.abs() <= 0.51 * step + 1e-9,
                    "map {id}, link {link}: {error} dB"
                );
            }
            checked += 1;
        }
        let original = traced.map(id).unwrap();
        assert_eq!(map.status, original.status);
        assert_eq!(
            (map.tx_m, map.rx_m, map.links),
            (original.tx_m, original.rx_m, original.links)
        );
    }
    assert!(checked > 200, "{checked}");
}

#[test]
fn killed_relabelling_is_continued() {
    let folder = Folder::new();
    folder.make("traced", &[SETTINGS, "aps,paths"]);
    relabel(&folder, "traced", "whole", "--fs-hz 1e8");
    relabel(&folder, "traced", "resumed", "--fs-hz 1e8");
    // As if it had been stopped before its last map.
    std::fs::remove_file(folder.path("resumed/manifest.json")).unwrap();
    std::fs::remove_dir_all(folder.path("resumed/map_0002")).unwrap();
    relabel(&folder, "traced", "resumed", "--fs-hz 1e8");
    folder.assert_same("whole", "resumed");
    let [from, out] = ["traced", "resumed"].map(|name| folder.arg(name));
    let told = fail(&format!("relabel {from} --out {out} --fs-hz 2e8"));
    let difference = "configuration.label.sampling_rate_hz is 100000000.0 there, 200000000.0 here";
    assert!(told.contains(difference), "{told}");
}

#[test]
fn a_folder_that_cannot_be_made_is_not_laid_to_the_source() {
    let folder = Folder::new();
    folder.make("source", &[SETTINGS, "aps,paths"]);
    std::fs::write(folder.path("file"), "").unwrap();
    let [source, out] = ["source", "file/new"].map(|name| folder.arg(name));
    let told = fail(&format!("relabel {source} --out {out}"));
    assert!(told.contains(&out) && !told.contains(&source), "{told}");
}

#[test]
fn data_set_without_paths_says_how_to_make_one_with_them() {
    let folder = Folder::new();
    folder.make("labels", &["--maps synthetic:3 --profile smoke"]);
    let [from, out] = ["labels", "new"].map(|name| folder.arg(name));
    let told = fail(&format!("relabel {from} --out {out}"));
    assert_told(
        &told,
        &["stores no paths", "cargo xtask dataset --store aps,paths"],
    );
    assert!(!folder.path("new").exists());
}

#[test]
fn damaged_source_is_not_given_new_checksums() {
    let folder = Folder::new();
    folder.make("traced", &[SETTINGS, "aps,paths"]);
    let array = folder.path("traced/map_0001/path_delay_s.npy");
    let mut bytes = std::fs::read(&array).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&array, bytes).unwrap();
    let [from, out] = ["traced", "new"].map(|name| folder.arg(name));
    let told = fail(&format!("relabel {from} --out {out}"));
    assert_told(&told, &["map_0001/path_delay_s.npy", "SHA-256"]);
    assert!(folder.path("new/map_0000").exists() && !folder.path("new/map_0001").exists());
}
