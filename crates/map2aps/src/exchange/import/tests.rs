use std::fs;
use std::path::{Path, PathBuf};

use aps_data::Dataset;
use aps_data::propbin::{Propbin, Version};

use super::*;
use crate::error::Result;
use crate::{Control, DatasetPlan, Export, ExportLayout, MapSource, Verify, synthetic};

/// Seed of the synthetic maps and of the imports.
const SEED: u64 = 7;
const SYNTHETIC: MapSource = MapSource::Synthetic { count: 2 };

/// Labels of maps as published files in the folder `root/files`, and their number.
fn exported(root: &Path, maps: MapSource, ids: &[u32]) -> (PathBuf, usize) {
    let [data, files] = ["data", "files"].map(|name| root.join(name));
    let plan = DatasetPlan {
        maps,
        seed: SEED,
        stored: aps_data::Stored {
            paths: true,
            ..Default::default()
        },
        ..synthetic::plan(2, 2, 30)
    };
    let dataset = synthetic::made(&plan, &data, ids);
    let export = Export::new(ExportLayout::Released);
    let exported = export.run(&dataset, &files, &Control::default()).unwrap();
    (files, exported.links)
}

/// Labels of synthetic cities as published files, in the folder that is returned.
fn released() -> (tempfile::TempDir, PathBuf, usize) {
    let root = tempfile::tempdir().unwrap();
    let (files, links) = exported(root.path(), SYNTHETIC, &[0, 1]);
    (root, files, links)
}

fn import_into(out: &Path, folder: &Path, maps: Option<MapSource>) -> Result<Imported> {
    let import = ImportReleased {
        folder: folder.into(),
        maps,
        seed: SEED,
    };
    import.run(out, &Control::default())
}

fn import(folder: &Path, maps: Option<MapSource>) -> Result<Imported> {
    import_into(tempfile::tempdir().unwrap().path(), folder, maps)
}

#[test]
fn files_of_another_source_are_not_put_beside_those_of_the_first() {
    let (root, files, _) = released();
    let out = root.path().join("out");
    let run = |folder: &Path| import_into(&out, folder, None);
    run(&files).unwrap();
    run(&files).unwrap();
    // One link less: another list of files of map 1.
    let folder = files.join("map_1/1_adps/aps");
    let mut entries = fs::read_dir(folder).unwrap();
    fs::remove_file(entries.next().unwrap().unwrap().path()).unwrap();
    for finished in [true, false] {
        if !finished {
            fs::remove_file(out.join("manifest.json")).unwrap();
            fs::remove_dir_all(out.join("map_0000")).unwrap();
        }
        let error = told(run(&files));
        assert!(
            error.contains("map 1 in") && error.contains("another source"),
            "{error}"
        );
    }
}

fn told(result: Result<Imported>) -> String {
    result.unwrap_err().chain()
}

#[test]
fn zeros_before_numbers_do_not_hide_a_file_nor_make_two_links_of_one() {
    let (root, files, links) = released();
    let old = files.join("map_1/1_adps");
    let mut entries = fs::read_dir(old.join("aps")).unwrap();
    let aps = entries.next().unwrap().unwrap().path();
    let name = aps.file_name().unwrap().to_str().unwrap();
    let padded = name.replace("aps_1_", "aps_001_0");
    let renamed = aps.with_file_name(&padded);
    fs::copy(&aps, &renamed).unwrap();
    let error = told(import(&files, None));
    assert!(error.contains("are the same link"), "{error}");
    assert!(error.contains(name) && error.contains(&padded), "{error}");

    fs::remove_file(&aps).unwrap();
    let [pdp, other] =
        [name, &padded].map(|name| old.join("pdp").join(name.replace("aps_", "pdp_")));
    fs::rename(pdp, other).unwrap();
    fs::rename(&old, files.join("map_1/01_adps")).unwrap();
    fs::rename(files.join("map_1"), files.join("map_001")).unwrap();
    let imported = import(&files, None).unwrap();
    assert_eq!(
        (imported.totals.maps, imported.totals.links),
        (2, links as u64)
    );

    // A folder of something else, as of a date, may have any number.
    let date = files.join("map_20240101120000");
    fs::create_dir(&date).unwrap();
    import(&files, None).unwrap();

    let large = files.join("map_99999999999999");
    fs::rename(files.join("map_001"), &large).unwrap();
    let error = told(import(&files, None));
    assert!(
        error.contains("map_99999999999999") && error.contains("4294967295"),
        "{error}"
    );
    let propbin = ImportPropbin {
        source: large.join("source_0.propbin"),
        map_id: 0,
        maps: None,
        rx_per_map: None,
        label: Default::default(),
        stored: aps_data::Stored::default(),
        seed: SEED,
    };
    fs::write(&propbin.source, "").unwrap();
    let error = told(propbin.run(&root.path().join("out"), &Control::default()));
    assert!(error.contains("map_99999999999999"), "{error}");
    // Further above it is none of a map, and the number that is given holds.
    let inner = date.join("runs");
    fs::create_dir(&inner).unwrap();
    let mut file = Propbin::new(Version::Full, [0.0; 3]);
    file.add_receiver(7, [30.0, 20.0, 1.5], None, None);
    fs::write(inner.join("source_0.propbin"), file.to_bytes().unwrap()).unwrap();
    let propbin = ImportPropbin {
        source: inner,
        map_id: 5,
        ..propbin
    };
    let out = root.path().join("out");
    propbin.run(&out, &Control::default()).unwrap();
    assert_eq!(Dataset::open(&out).unwrap().manifest().maps[0].id, 5);
}

#[test]
fn an_import_with_maps_is_verified_by_them() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("maps");
    fs::create_dir(&folder).unwrap();
    // A slit of a centimetre, which is filled.
    let houses = "[[[40, 40], [60, 40], [60, 60], [40, 60]], [[60.01, 40], [80, 40], [80, 60], [60.01, 60]]]";
    fs::write(folder.join("0.json"), houses).unwrap();
    let folder = MapSource::Folder(folder);
    for (maps, ids, name) in [(SYNTHETIC, &[0, 1][..], "cities"), (folder, &[0], "slit")] {
        let folder = root.path().join(name);
        let out = folder.join("out");
        let (files, _) = exported(&folder, maps.clone(), ids);
        import_into(&out, &files, Some(maps.clone())).unwrap();
        let verify = Verify {
            maps: Some(maps),
            ..Verify::default()
        };
        let mut found = Vec::new();
        let dataset = Dataset::open(&out).unwrap();
        let verified = verify.run(&dataset, &Control::default(), &mut |line| found.push(line));
        verified.unwrap();
        assert!(found.is_empty(), "{name}: {found:?}");
    }
}

#[test]
fn labels_with_the_buildings_of_another_map_are_refused() {
    let (_root, files, links) = released();
    let imported = import(&files, Some(SYNTHETIC)).unwrap();
    assert_eq!(imported.totals.links, links as u64);
    // The cities of each other.
    for (from, to) in [("map_0", "aside"), ("map_1", "map_0"), ("aside", "map_1")] {
        fs::rename(files.join(from), files.join(to)).unwrap();
    }
    for (new, old) in [(0, 1), (1, 0)] {
        let map = files.join(format!("map_{new}"));
        fs::rename(
            map.join(format!("{old}_adps")),
            map.join(format!("{new}_adps")),
        )
        .unwrap();
        for kind in ["aps", "pdp"] {
            for entry in fs::read_dir(map.join(format!("{new}_adps/{kind}"))).unwrap() {
                let path = entry.unwrap().path();
                let name = path.file_name().unwrap().to_str().unwrap();
                let [old, new] = [old, new].map(|id| format!("{kind}_{id}_"));
                fs::rename(&path, path.with_file_name(name.replacen(&old, &new, 1))).unwrap();
            }
        }
    }
    let error = told(import(&files, Some(SYNTHETIC)));
    assert!(
        error.contains("inside a building of the map") && error.contains("of 60 links"),
        "{error}"
    );
}
