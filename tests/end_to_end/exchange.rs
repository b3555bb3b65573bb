//! `export` and `import`: the published data's files from a data set, and back.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use aps_data::propbin::{Chain, Direction, Path as RayPath, Propbin, Version};
use aps_data::released::{LinkName, ProfileFile, Sample};
use aps_data::{Dataset, InteractionKind, LinkStatus};

use crate::folder::{Folder, files};
use crate::{assert_told, fail, succeed};

/// A small data set with these arrays.
fn make(folder: &Folder, out: &str, store: &str) -> Dataset {
    folder.make(out, &["--profile smoke --protocol released --store", store]);
    Dataset::open(folder.path(out)).unwrap()
}

/// Exports one folder into another; options may follow the layout.
fn export(folder: &Folder, from: &str, out: &str, layout: &str) {
    let (from, out) = (folder.arg(from), folder.arg(out));
    succeed(&format!("export {from} --out {out} --layout {layout}"));
}

/// Imports one folder into another.
fn import(folder: &Folder, kind: &str, from: &str, out: &str) -> Dataset {
    let data = folder.arg(out);
    // Only paths are labelled anew.
    let protocol = if kind == "propbin" {
        "--protocol released"
    } else {
        ""
    };
    let from = folder.arg(from);
    succeed(&format!("import {kind} {from} --out {data} {protocol}"));
    Dataset::open(data).unwrap()
}

/// Every file but the record of the export and its lock.
fn exported(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = files(root);
    for own in ["export.json", ".lock"] {
        assert!(files.remove(own).is_some(), "{own}");
    }
    files
}

#[test]
fn labels_leave_come_back_and_leave_again_unchanged() {
    let folder = Folder::new();
    let ours = make(&folder, "ours", "aps,pdp,paths");
    export(&folder, "ours", "first", "released");
    let first = folder.path("first");

    // Each file holds the label of its link, to half precision.
    let map = ours.map(0).unwrap();
    let link = map.valid_links().nth(7).unwrap();
    let (tx, rx) = map.ends_m(link);
    let name = LinkName::of(0, tx, rx).unwrap();
    let file = ProfileFile::from_bytes(&fs::read(first.join(name.aps_file())).unwrap()).unwrap();
    let aps = map.aps.as_ref().unwrap();
    let mut row = vec![0.0; 180];
    aps.read_relative_db(link, &mut row);
    for (bin, relative) in file.bins.iter().zip(row) {
        let stored = relative + aps.max_db()[link];
        let read = bin[0].to_f32();
        assert!(
            (read - stored).abs() <= stored.abs() / 1024.0,
            "{read} is not {stored}"
        );
        assert!((0.0..=1000.0).contains(&bin[1].to_f32()));
    }
    let pdp = ProfileFile::from_bytes(&fs::read(first.join(name.pdp_file())).unwrap()).unwrap();
    assert_eq!(pdp.bins.len(), 128);
    assert!(pdp.bins.iter().all(|bin| bin[1].to_f32().abs() <= 180.0));

    let imported = import(&folder, "released", "first", "back");
    assert_eq!(imported.verify().len(), 0);
    let valid = |dataset: &Dataset| dataset.manifest().totals.status["valid"];
    assert_eq!(valid(&imported), valid(&ours));
    export(&folder, "back", "again", "released");
    assert!(
        exported(&first) == exported(&folder.path("again")),
        "a round trip changed a file"
    );
}

#[test]
fn export_continues_where_it_was_and_keeps_to_its_data() {
    let folder = Folder::new();
    make(&folder, "data", "aps,paths");
    let exported = |out: &str, more: &str| {
        export(&folder, "data", out, &format!("released {more}"));
        exported(&folder.path(out))
    };
    let whole = exported("whole", "--threads 2");
    let some = exported("parts", "--limit 10 --threads 1");
    assert_eq!(some.len(), 20);
    // Cut short, as a power cut may leave it.
    let (name, bytes) = some.first_key_value().unwrap();
    fs::write(folder.path("parts").join(name), &bytes[..100]).unwrap();
    assert!(whole == exported("parts", ""), "continuing changed a file");
    assert!(exported("test", "--part test").len() < whole.len());

    folder.make(
        "other",
        &["--profile smoke --protocol released --seed 7 --store aps,paths"],
    );
    let (other, parts) = (folder.arg("other"), folder.arg("parts"));
    let error = fail(&format!("export {other} --layout released --out {parts}"));
    assert!(error.contains("another export"), "{error}");
}

#[test]
fn what_cannot_be_exported_is_explained() {
    let folder = Folder::new();
    make(&folder, "aps", "aps");
    folder.make("paper", &["--profile smoke"]);
    let [aps, paper, out, new] = ["aps", "paper", "out", "new"].map(|name| folder.arg(name));
    let error = fail(&format!("export {aps} --layout released --out {out}"));
    assert!(error.contains("--store aps,paths"), "{error}");
    let error = fail(&format!("export {paper} --layout samples --out {out}"));
    assert_told(&error, &["`paper`", "--any-protocol"]);
    folder.make(
        "one",
        &["--maps synthetic:1 --protocol released --tx-per-map 2 --rx-per-map 9"],
    );
    let one = folder.arg("one");
    let error = fail(&format!(
        "export {one} --layout samples --part test --out {out}"
    ));
    assert_told(&error, &["has no test maps", "name another part"]);
    let city = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/data/helsinki.geojson"
    );
    folder.make(
        "fine",
        &[
            "--protocol released --tx-per-map 1 --rx-per-map 4 --tile 128 --map-ids 0 --maps",
            city,
        ],
    );
    let fine = folder.arg("fine");
    let error = fail(&format!("export {fine} --layout samples --out {new}"));
    assert_told(&error, &["a pixel is 0.5 m", "another layout"]);
    assert!(!folder.path("new").exists());
    for kind in ["released", "samples", "propbin"] {
        let error = fail(&format!("import {kind} {aps} --out {new}"));
        assert!(
            error.contains("nothing to import") || error.contains("cannot read"),
            "{error}"
        );
    }
}

#[test]
fn samples_are_what_models_train_on_and_come_back() {
    let folder = Folder::new();
    let ours = make(&folder, "data", "aps");
    export(&folder, "data", "out", "samples --limit 30");
    let out = folder.path("out");
    let map = ours.map(0).unwrap();
    let (tx, rx) = map.ends_m(map.valid_links().next().unwrap());
    let name = LinkName::of(0, tx, rx).unwrap();
    let sample = Sample::from_npz(&fs::read(out.join(name.sample_file())).unwrap()).unwrap();
    assert_eq!((sample.aps_norm.len(), sample.size), (180, [256, 256]));
    let mean: f32 = sample.aps_norm.iter().sum::<f32>() / 180.0;
    let square: f32 = sample.aps_norm.iter().map(|v| v * v).sum::<f32>() / 180.0;
    assert!(
        mean.abs() < 1e-5 && (square - 1.0).abs() < 1e-4,
        "{mean} {square}"
    );
    let pixel = |plane: usize, [x, y]: [i32; 2]| {
        sample.cond_img[(plane * 256 + y as usize) * 256 + x as usize]
    };
    assert_eq!((pixel(1, name.tx_m), pixel(2, name.rx_m)), (1.0, 1.0));
    let table = fs::read_to_string(out.join("metadata.csv")).unwrap();
    assert_eq!(table.lines().count(), 31);
    assert!(out.join("env_maps/0.npy").is_file());

    let imported = import(&folder, "samples", "out", "back");
    assert_eq!(
        (imported.verify().len(), imported.manifest().totals.links),
        (0, 30)
    );
    // As an export leaves it that was interrupted.
    fs::remove_file(out.join("metadata.csv")).unwrap();
    let (from, to) = (folder.arg("out"), folder.arg("half"));
    let error = fail(&format!("import samples {from} --out {to}"));
    assert!(error.contains("was not finished"), "{error}");
    assert_eq!(imported.map(0).unwrap().buildings, map.buildings);
    export(&folder, "back", "again", "samples");
    let again = folder.path("again").join(name.sample_file());
    let same = Sample::from_npz(&fs::read(again).unwrap()).unwrap();
    assert_eq!(same.cond_img, sample.cond_img);
    for (a, b) in same.aps_norm.iter().zip(&sample.aps_norm) {
        assert!((a - b).abs() < 1e-5 * (1.0 + b.abs()), "{a} is not {b}");
    }
}

/// The paths of a data set's map 0 as files of a version, one a transmitter.
fn write_propbins(dataset: &Dataset, version: Version, folder: &Path) {
    fs::create_dir_all(folder).unwrap();
    let (map, paths) = (dataset.map(0).unwrap(), dataset.paths(0).unwrap());
    let at = |p: [f64; 2]| [p[0] as f32, p[1] as f32, 1.5];
    for (t, tx) in map.tx_m.iter().enumerate() {
        let mut file = Propbin::new(version, at(*tx));
        for link in (0..map.links.len()).filter(|&link| map.links[link][0] as usize == t) {
            let (_, rx) = map.ends_m(link);
            file.add_receiver(link as i32, at(rx), None, None);
            for p in paths.paths_of(link) {
                let [re, im] = paths.gain[p];
                let direction = |azimuth: f64| Direction {
                    azimuth_rad: azimuth as f32,
                    elevation_rad: 0.0,
                };
                let path = RayPath {
                    loss_db: (-10.0 * (re * re + im * im).log10()) as f32,
                    length_m: (paths.delay_s[p] * 299_792_458.0) as f32,
                    delay_ns: (paths.delay_s[p] * 1e9) as f32,
                    departure: direction(paths.departure_azimuth_rad[p]),
                    arrival: direction(paths.arrival_azimuth_rad[p] + std::f64::consts::PI),
                };
                let points = paths.interactions_of(p);
                let points = points.map(|i| at(paths.interaction_point_m[i]));
                let chain = match version {
                    Version::Full => {
                        let whole = std::iter::once(at(*tx)).chain(points).chain([at(rx)]);
                        Chain::Points(whole.collect())
                    }
                    Version::Compact => Chain::Vertices(points.map(|_| 3).collect()),
                };
                file.add_path(&path, &chain).unwrap();
            }
        }
        let (name, bytes) = match version {
            Version::Full => (format!("source_{t}.propbin"), file.to_bytes()),
            Version::Compact => (format!("source_{t}.propbin.gz"), file.to_gzip()),
        };
        fs::write(folder.join(name), bytes.unwrap()).unwrap();
    }
}

#[test]
fn paths_written_by_others_are_labelled_like_traced_ones() {
    let folder = Folder::new();
    let ours = make(&folder, "ours", "aps,paths");
    let expected = ours.map(0).unwrap();
    let traced = ours.paths(0).unwrap();
    // A delay in half precision is off by up to 0.25 ns, which moves a label by decibels.
    for (version, tolerance_db) in [(Version::Full, 0.05), (Version::Compact, 8.0)] {
        let [from, out] = [format!("{version:?}"), format!("{version:?}-data")];
        let inner = "map_3/special_points_propbin_3.5GHz";
        write_propbins(&ours, version, &folder.path(&from).join(inner));
        let dataset = import(&folder, "propbin", &from, &out);
        assert_eq!(dataset.verify().len(), 0);
        let map = dataset.map(3).unwrap();
        let paths = dataset.paths(3).unwrap();
        assert_eq!(map.tx_m, expected.tx_m);
        for link in 0..map.links.len() {
            // Receivers are in another order.
            let is_same = |&l: &usize| expected.ends_m(l) == map.ends_m(link);
            let same = (0..expected.links.len()).find(is_same).unwrap();
            let (range, other) = (paths.paths_of(link), traced.paths_of(same));
            assert_eq!(range.len(), other.len());
            for (p, q) in range.zip(other) {
                let turn = paths.arrival_azimuth_rad[p] - traced.arrival_azimuth_rad[q];
                assert!((turn.sin()).abs() < 2e-3 && turn.cos() > 0.0, "{turn}");
                let expected = match version {
                    Version::Full => traced.interactions_of(q).len(),
                    Version::Compact => 0,
                };
                assert_eq!(paths.interactions_of(p).len(), expected);
            }
            assert_eq!(
                map.status[link].is_valid(),
                expected.status[same].is_valid()
            );
            if map.status[link] == LinkStatus::Valid {
                let peaks = [(&map, link), (&expected, same)]
                    .map(|(map, l)| map.aps.as_ref().unwrap().max_db()[l]);
                assert!(
                    (peaks[0] - peaks[1]).abs() < tolerance_db,
                    "{version:?}: {peaks:?}"
                );
            }
        }
        let mut kinds = paths.interaction_kind.iter();
        assert!(kinds.all(|kind| *kind == InteractionKind::Other(255)));
    }
}

#[test]
fn angles_in_degrees_are_refused() {
    let folder = Folder::new();
    for (name, departure, arrival) in [("arrival", 0.5, 135.0), ("departure", -90.0, 0.5)] {
        let mut file = Propbin::new(Version::Full, [10.0, 20.0, 1.5]);
        file.add_receiver(7, [30.0, 20.0, 1.5], None, None);
        let direction = |azimuth_rad| Direction {
            azimuth_rad,
            elevation_rad: 0.0,
        };
        let path = RayPath {
            loss_db: 61.0,
            length_m: 20.0,
            delay_ns: 66.7,
            departure: direction(departure),
            arrival: direction(arrival),
        };
        file.add_path(&path, &Chain::Points([].as_slice().into()))
            .unwrap();
        fs::write(folder.path("source_0.propbin"), file.to_bytes().unwrap()).unwrap();
        let (source, out) = (folder.arg("source_0.propbin"), folder.arg("out"));
        let told = fail(&format!("import propbin {source} --out {out}"));
        assert_told(&told, &["receiver 7", name, "are the units radians?"]);
    }
}

#[test]
fn a_bad_sample_is_told_once() {
    let folder = Folder::new();
    make(&folder, "ours", "aps");
    export(&folder, "ours", "samples", "samples --limit 1");
    let mut files = fs::read_dir(folder.path("samples/samples")).unwrap();
    let file = files.next().unwrap().unwrap().path();
    let whole = fs::read(&file).unwrap();
    let told = |bytes: &[u8]| {
        fs::write(&file, bytes).unwrap();
        let (from, to) = (folder.arg("samples"), folder.arg("imported"));
        fail(&format!("import samples {from} --out {to}"))
    };
    let error = told(&whole[..whole.len() / 2]);
    let cause = error.trim_end().rsplit(": ").next().unwrap();
    assert_eq!(error.matches(cause).count(), 1, "{error}");
    assert!(error.contains("not a readable .npz archive"), "{error}");
}

/// A link left out because of its name would be missing from all scores.
#[test]
fn files_whose_names_tell_no_link_are_refused() {
    let folder = Folder::new();
    make(&folder, "ours", "aps,paths");
    export(&folder, "ours", "theirs", "released");
    let root = folder.path("theirs/map_1");
    let files = root.join("1_adps/aps");
    let file = fs::read_dir(&files)
        .unwrap()
        .next()
        .unwrap()
        .unwrap()
        .path();
    let import = || {
        fail(&format!(
            "import released {} --out {}",
            folder.arg("theirs"),
            folder.arg("back")
        ))
    };
    for name in ["aps_1_2.5_3_4_5.npy", "aps_0_2_3_4_5.npy"] {
        let renamed = files.join(name);
        fs::rename(&file, &renamed).unwrap();
        let told = import();
        assert!(
            told.contains("does not tell its link by its name"),
            "{name}: {told}"
        );
        fs::rename(&renamed, &file).unwrap();
    }
}

#[test]
fn receivers_can_be_drawn_and_two_forms_of_one_file_are_refused() {
    let folder = Folder::new();
    let ours = make(
        &folder,
        "ours",
        "aps,paths --receivers outdoor --max-reflections 0 --max-diffractions 0",
    );
    let paths = ours.paths(0).unwrap();
    assert!((0..paths.links()).any(|link| paths.paths_of(link).is_empty()));
    let written = folder.path("map_5");
    write_propbins(&ours, Version::Compact, &written);
    let [from, out, new] = ["map_5", "data", "new"].map(|name| folder.arg(name));
    succeed(&format!("import propbin {from} --rx-per-map 5 --out {out}"));
    let map = Dataset::open(&out).unwrap().map(5).unwrap();
    assert_eq!((map.rx_m.len(), map.links.len()), (5, 20));

    let refused = || {
        let error = fail(&format!("import propbin {from} --out {new}"));
        assert!(error.contains("the same transmitter"), "{error}");
    };
    let files = || {
        fs::read_dir(&written)
            .unwrap()
            .map(|file| file.unwrap().path())
    };
    let numbered = |file: &PathBuf| file.to_string_lossy().contains("_1.propbin");
    let first = files().find(numbered).unwrap();
    let same = written.join("another_1.propbin.gz");
    fs::copy(first, &same).unwrap();
    refused();
    fs::remove_file(same).unwrap();
    write_propbins(&ours, Version::Full, &written);
    refused();
}
