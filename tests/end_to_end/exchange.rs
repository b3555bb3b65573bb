//! `export` and `import`: the published data's files from a data set, and back.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use aps_data::propbin::{Chain, Direction, Path as RayPath, Propbin, Version};
use aps_data::released::{LinkName, ProfileFile, Sample};
use aps_data::{Dataset, InteractionKind, LinkStatus};

use crate::folder::files;
use crate::{fail, succeed};

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn make(out: &Path, store: &str) -> Dataset {
    succeed(&[
        "dataset",
        "--profile",
        "smoke",
        "--store",
        store,
        "--out",
        text(out),
    ]);
    Dataset::open(out).unwrap()
}

/// Every file but the record of the export.
fn exported(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = files(root);
    assert!(files.remove("export.json").is_some());
    files
}

#[test]
fn labels_leave_come_back_and_leave_again_unchanged() {
    let root = tempfile::tempdir().unwrap();
    let path = |name| root.path().join(name);
    let ours = make(&path("ours"), "aps,pdp,paths");
    let (first, again) = (path("first"), path("again"));
    succeed(&[
        "export",
        text(&path("ours")),
        "--layout",
        "released",
        "--out",
        text(&first),
    ]);

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

    let back = path("back");
    succeed(&["import", "released", text(&first), "--out", text(&back)]);
    let imported = Dataset::open(&back).unwrap();
    assert_eq!(imported.verify().len(), 0);
    let valid = |dataset: &Dataset| dataset.manifest().totals.status["valid"];
    assert_eq!(valid(&imported), valid(&ours));
    succeed(&[
        "export",
        text(&back),
        "--layout",
        "released",
        "--out",
        text(&again),
    ]);
    assert!(
        exported(&first) == exported(&again),
        "a round trip changed a file"
    );
}

#[test]
fn export_continues_where_it_was_and_keeps_to_its_data() {
    let root = tempfile::tempdir().unwrap();
    let path = |name| root.path().join(name);
    make(&path("data"), "aps,paths");
    let data = path("data");
    let export = |out: &Path, more: &[&str]| {
        let base = [
            "export",
            text(&data),
            "--layout",
            "released",
            "--out",
            text(out),
        ];
        succeed(&[&base[..], more].concat())
    };
    let (whole, parts) = (path("whole"), path("parts"));
    export(&whole, &["--threads", "2"]);
    export(&parts, &["--limit", "10", "--threads", "1"]);
    let some = exported(&parts);
    assert_eq!(some.len(), 20);
    // Cut short, as a power cut may leave it.
    let (name, bytes) = some.first_key_value().unwrap();
    fs::write(parts.join(name), &bytes[..100]).unwrap();
    export(&parts, &[]);
    assert!(
        exported(&whole) == exported(&parts),
        "continuing changed a file"
    );

    let test = path("test");
    export(&test, &["--part", "test"]);
    assert!(exported(&test).len() < exported(&whole).len());

    let other = path("other");
    succeed(&[
        "dataset",
        "--profile",
        "smoke",
        "--seed",
        "7",
        "--store",
        "aps,paths",
        "--out",
        text(&other),
    ]);
    let error = fail(&[
        "export",
        text(&other),
        "--layout",
        "released",
        "--out",
        text(&parts),
    ]);
    assert!(error.contains("another export"), "{error}");
}

#[test]
fn what_cannot_be_exported_is_explained() {
    let root = tempfile::tempdir().unwrap();
    let path = |name| root.path().join(name);
    make(&path("aps"), "aps");
    let out = path("out");
    let args = |data: &Path, layout: &str| -> Vec<String> {
        [
            "export",
            text(data),
            "--layout",
            layout,
            "--out",
            text(&out),
        ]
        .map(String::from)
        .to_vec()
    };
    let run = |args: Vec<String>| fail(&args.iter().map(String::as_str).collect::<Vec<_>>());
    let error = run(args(&path("aps"), "released"));
    assert!(error.contains("--store aps,paths"), "{error}");
    let paper = path("paper");
    succeed(&[
        "dataset",
        "--profile",
        "smoke",
        "--protocol",
        "paper",
        "--out",
        text(&paper),
    ]);
    let error = run(args(&paper, "samples"));
    assert!(
        error.contains("`paper`") && error.contains("--any-protocol"),
        "{error}"
    );
    for kind in ["released", "samples", "propbin"] {
        let error = fail(&[
            "import",
            kind,
            text(&path("aps")),
            "--out",
            text(&path("new")),
        ]);
        assert!(
            error.contains("nothing to import") || error.contains("cannot read"),
            "{error}"
        );
    }
}

#[test]
fn samples_are_what_models_train_on_and_come_back() {
    let root = tempfile::tempdir().unwrap();
    let path = |name| root.path().join(name);
    let ours = make(&path("data"), "aps");
    let out = path("out");
    succeed(&[
        "export",
        text(&path("data")),
        "--layout",
        "samples",
        "--limit",
        "30",
        "--out",
        text(&out),
    ]);
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

    let back = path("back");
    succeed(&["import", "samples", text(&out), "--out", text(&back)]);
    let imported = Dataset::open(&back).unwrap();
    assert_eq!(
        (imported.verify().len(), imported.manifest().totals.links),
        (0, 30)
    );
    assert_eq!(imported.map(0).unwrap().buildings, map.buildings);
    let again = path("again");
    succeed(&[
        "export",
        text(&back),
        "--layout",
        "samples",
        "--out",
        text(&again),
    ]);
    let same = Sample::from_npz(&fs::read(again.join(name.sample_file())).unwrap()).unwrap();
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
                let points = paths
                    .interactions_of(p)
                    .map(|i| at(paths.interaction_point_m[i]));
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
    let root = tempfile::tempdir().unwrap();
    let ours = make(&root.path().join("ours"), "aps,paths");
    let expected = ours.map(0).unwrap();
    let traced = ours.paths(0).unwrap();
    // A delay in half precision is off by up to 0.25 ns, which moves a label by decibels.
    for (version, tolerance_db) in [(Version::Full, 0.05), (Version::Compact, 8.0)] {
        let folder = root.path().join(format!("{version:?}"));
        write_propbins(
            &ours,
            version,
            &folder.join("map_3/special_points_propbin_3.5GHz"),
        );
        let out = root.path().join(format!("{version:?}-data"));
        succeed(&["import", "propbin", text(&folder), "--out", text(&out)]);
        let dataset = Dataset::open(&out).unwrap();
        assert_eq!(dataset.verify().len(), 0);
        let map = dataset.map(3).unwrap();
        let paths = dataset.paths(3).unwrap();
        assert_eq!(map.tx_m, expected.tx_m);
        for link in 0..map.links.len() {
            // Receivers are in another order.
            let same = (0..expected.links.len())
                .find(|&l| expected.ends_m(l) == map.ends_m(link))
                .unwrap();
            let (range, other) = (paths.paths_of(link), traced.paths_of(same));
            assert_eq!(range.len(), other.len());
            for (p, q) in range.zip(other) {
                let turn = paths.arrival_azimuth_rad[p] - traced.arrival_azimuth_rad[q];
                assert!((turn.sin()).abs() < 2e-3 && turn.cos() > 0.0, "{turn}");
                let points = |i: std::ops::Range<usize>| i.len();
                match version {
                    Version::Full => {
                        assert_eq!(
                            points(paths.interactions_of(p)),
                            points(traced.interactions_of(q))
                        );
                    }
                    Version::Compact => assert_eq!(points(paths.interactions_of(p)), 0),
                }
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
        assert!(
            paths
                .interaction_kind
                .iter()
                .all(|kind| *kind == InteractionKind::Other(255))
        );
    }
}

#[test]
fn angles_in_degrees_are_refused() {
    let root = tempfile::tempdir().unwrap();
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
        let source = root.path().join("source_0.propbin");
        fs::write(&source, file.to_bytes().unwrap()).unwrap();
        let out = root.path().join("out");
        let told = fail(&["import", "propbin", text(&source), "--out", text(&out)]);
        assert!(told.contains("receiver 7") && told.contains(name), "{told}");
        assert!(told.contains("are the units radians?"), "{told}");
    }
}

#[test]
fn a_bad_sample_is_told_once() {
    let root = tempfile::tempdir().unwrap();
    make(&root.path().join("ours"), "aps");
    let out = root.path().join("samples");
    let export = [
        "export",
        text(&root.path().join("ours")),
        "--layout",
        "samples",
        "--out",
    ]
    .map(str::to_owned);
    let export: Vec<&str> = export
        .iter()
        .map(String::as_str)
        .chain([text(&out), "--limit", "1"])
        .collect();
    succeed(&export);
    let file = fs::read_dir(out.join("samples"))
        .unwrap()
        .next()
        .unwrap()
        .unwrap()
        .path();
    let whole = fs::read(&file).unwrap();
    let told = |bytes: &[u8]| {
        fs::write(&file, bytes).unwrap();
        let to = root.path().join("imported");
        fail(&["import", "samples", text(&out), "--out", text(&to)])
    };
    let error = told(&whole[..whole.len() / 2]);
    let cause = error.trim_end().rsplit(": ").next().unwrap();
    assert_eq!(error.matches(cause).count(), 1, "{error}");
    assert!(error.contains("not a readable .npz archive"), "{error}");
}

#[test]
fn receivers_can_be_drawn_and_two_forms_of_one_file_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let made = root.path().join("ours");
    let grid = "dataset --profile smoke --store aps,paths --receivers outdoor --out".split(' ');
    succeed(&grid.chain([text(&made)]).collect::<Vec<_>>());
    let ours = Dataset::open(&made).unwrap();
    let folder = root.path().join("map_5");
    write_propbins(&ours, Version::Compact, &folder);
    let out = root.path().join("data");
    succeed(&[
        "import",
        "propbin",
        text(&folder),
        "--rx-per-map",
        "5",
        "--out",
        text(&out),
    ]);
    let map = Dataset::open(&out).unwrap().map(5).unwrap();
    assert_eq!((map.rx_m.len(), map.links.len()), (5, 20));

    write_propbins(&ours, Version::Full, &folder);
    let error = fail(&[
        "import",
        "propbin",
        text(&folder),
        "--out",
        text(&root.path().join("new")),
    ]);
    assert!(error.contains("the same transmitter"), "{error}");
}
