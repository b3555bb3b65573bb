//! Maps that differ by less than a pixel from those that a data set was made of.

#[path = "../src/synthetic.rs"]
mod synthetic;

use std::fs;
use std::path::{Path, PathBuf};

use map2aps::{
    Control, Dataset, DatasetPlan, Export, ExportLayout, ImportReleased, LinkSource, MapSource,
    Stored, Verify,
};

/// Writes two maps of nine houses, whose north walls stand at a height over a whole number of metres.
fn write(folder: &Path, over_m: f64) {
    fs::create_dir_all(folder).unwrap();
    for id in 0..2 {
        let house = |i: usize| {
            let (x, y) = (20 + 70 * (i % 3) + 5 * id, 20 + 70 * (i / 3));
            let north = (y + 30) as f64 + over_m;
            format!("[[{x},{y}],[{0},{y}],[{0},{north}],[{x},{north}]]", x + 40)
        };
        let houses: Vec<String> = (0..9).map(house).collect();
        let text = format!("[{}]", houses.join(","));
        fs::write(folder.join(format!("{id}.json")), text).unwrap();
    }
}

fn plan(folder: PathBuf) -> DatasetPlan {
    DatasetPlan {
        maps: MapSource::Folder(folder),
        stored: Stored {
            paths: true,
            ..Stored::default()
        },
        ..synthetic::plan(2, 2, 10)
    }
}

#[test]
fn a_wall_moved_by_less_than_a_pixel_is_told_by_all_that_takes_maps() {
    let root = tempfile::tempdir().unwrap();
    let [own, other, out] = ["own", "other", "out"].map(|name| root.path().join(name));
    write(&own, 0.0);
    write(&other, 0.25);
    let control = Control::default();
    let first = synthetic::made(&plan(own.clone()), &out, &[0]);

    let told = plan(other.clone()).make(&out, &[0, 1], &control);
    let told = told.unwrap_err().chain();
    assert!(told.contains("it differs in outlines"), "{told}");

    let links = LinkSource::new(first.clone(), Some(MapSource::Folder(other.clone()))).unwrap();
    let told = links.map(0).unwrap_err().chain();
    assert!(told.contains("buildings differ"), "{told}");

    let mut found = Vec::new();
    let verify = Verify {
        maps: Some(MapSource::Folder(other.clone())),
        ..Verify::default()
    };
    verify
        .run(&first, &control, &mut |finding| found.push(finding))
        .unwrap();
    assert!(
        found.iter().any(|f| f.contains("buildings are not those")),
        "{found:?}"
    );

    // The name of the folder is nothing; its content is all.
    let sum = |folder: &Path| plan(folder.into()).buildings_sha256(&[0, 1]).unwrap();
    assert_eq!(sum(&own), sum(&own.join(".")));
    assert_ne!(sum(&own), sum(&other));
}

#[test]
fn an_import_is_not_continued_among_other_buildings() {
    let root = tempfile::tempdir().unwrap();
    let [own, other, data, files, out] =
        ["own", "other", "data", "files", "out"].map(|name| root.path().join(name));
    write(&own, 0.0);
    write(&other, 0.25);
    let dataset: Dataset = synthetic::made(&plan(own.clone()), &data, &[0, 1]);
    let control = Control::default();
    let export = Export::new(ExportLayout::Released);
    export.run(&dataset, &files, &control).unwrap();
    let import = |maps: &Path| {
        let import = ImportReleased {
            folder: files.clone(),
            maps: Some(MapSource::Folder(maps.into())),
            seed: 0,
        };
        import.run(&out, &control)
    };
    import(&own).unwrap();
    import(&own).unwrap();
    let told = import(&other).unwrap_err().chain();
    assert!(told.contains("it differs in outlines"), "{told}");
}
