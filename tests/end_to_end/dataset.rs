//! `dataset`: the same bytes for any threads and after a resume, arrays that hold what they say.

use std::fs;
use std::path::Path;

use aps_data::{Dataset, LinkStatus};

use crate::folder::files;
use crate::{fail, succeed};

fn make(out: &Path, more: &[&str]) -> String {
    let mut args = vec![
        "dataset",
        "--profile",
        "smoke",
        "--store",
        "aps,pdp,paths",
        "--out",
    ];
    args.push(out.to_str().unwrap());
    args.extend_from_slice(more);
    succeed(&args)
}

#[test]
fn threads_and_resume_change_no_byte() {
    let root = tempfile::tempdir().unwrap();
    let (one, two, resumed) = (
        root.path().join("one"),
        root.path().join("two"),
        root.path().join("resumed"),
    );
    make(&one, &["--threads", "1"]);
    make(&two, &["--threads", "2"]);
    // As if the run had been stopped between its two maps.
    make(&resumed, &["--threads", "2"]);
    fs::remove_file(resumed.join("manifest.json")).unwrap();
    fs::remove_dir_all(resumed.join("map_0001")).unwrap();
    make(&resumed, &["--threads", "1"]);
    let expected = files(&one);
    assert!(expected.len() > 20);
    assert!(expected == files(&two), "threads changed the data set");
    assert!(expected == files(&resumed), "a resume changed the data set");
}

#[test]
fn arrays_hold_what_they_say() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("data");
    let summary = make(&out, &[]);
    assert!(summary.contains("links/s"), "{summary}");

    let dataset = Dataset::open(&out).unwrap();
    assert_eq!(dataset.verify().len(), 0);
    assert_eq!(dataset.manifest().totals.links, 2 * 4 * 20);
    for entry in &dataset.manifest().maps {
        let map = dataset.map(entry.id).unwrap();
        let paths = dataset.paths(entry.id).unwrap();
        let aps = map.aps.as_ref().unwrap();
        let mut row = vec![0.0; aps.bins()];
        for link in 0..map.links.len() {
            let has_paths = !paths.paths_of(link).is_empty();
            assert_eq!(map.status[link] == LinkStatus::Valid, has_paths);
            aps.read_relative_db(link, &mut row);
            assert!(row.iter().all(|v| v.is_finite() && *v <= 0.0));
        }
        assert!(map.valid_links().count() > 70);
    }
}

#[test]
fn another_configuration_is_refused_by_name() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("data");
    make(&out, &[]);
    let out = out.to_str().unwrap();
    let error = fail(&[
        "dataset",
        "--profile",
        "smoke",
        "--store",
        "aps,pdp,paths",
        "--max-reflections",
        "1",
        "--out",
        out,
    ]);
    for difference in [
        "configuration.trace.max_interactions is 3 there, 2 here",
        "configuration.trace.max_reflections is 2 there, 1 here",
    ] {
        assert!(error.contains(difference), "{error}");
    }
}

#[test]
fn the_source_of_the_material_is_named() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("d");
    let source = |root: &Path| {
        let dataset = Dataset::open(root).unwrap();
        dataset
            .manifest()
            .configuration
            .pointer("/trace/material_source")
            .cloned()
    };
    make(&out, &[]);
    assert_eq!(source(&out), Some("ITU-R P.2040-3, table 3".into()));
    let pec = root.path().join("pec");
    make(&pec, &["--material", "pec"]);
    assert_eq!(source(&pec), None);
}

#[test]
fn mistakes_are_told() {
    let root = tempfile::tempdir().unwrap();
    let maps = root.path().join("maps");
    fs::create_dir(&maps).unwrap();
    let maps_arg = maps.to_str().unwrap();
    let out = root.path().join("data");
    let out = out.to_str().unwrap();

    let error = fail(&["dataset", "--maps", maps_arg, "--out", out]);
    assert!(error.contains("no map in"), "{error}");

    let error = fail(&["dataset", "--maps", "/nowhere/at/all", "--out", out]);
    assert!(error.contains("cannot read the maps"), "{error}");

    fs::write(maps.join("0.json"), "[[[0,0],[10,0],[10,\"x\"]]]").unwrap();
    let error = fail(&["dataset", "--maps", maps_arg, "--out", out]);
    assert!(
        error.contains("0.json") && error.contains("building 0, vertex 2"),
        "{error}"
    );

    fs::write(maps.join("0.json"), "[[[0,0],[256,0],[256,256],[0,256]]]").unwrap();
    let error = fail(&["dataset", "--maps", maps_arg, "--out", out]);
    assert!(error.contains("outdoor grid points"), "{error}");

    let error = fail(&[
        "dataset",
        "--maps",
        maps_arg,
        "--map-ids",
        "0-3",
        "--out",
        out,
    ]);
    assert!(error.contains("[1, 2, 3] are not there"), "{error}");
}

#[test]
fn orders_that_cannot_be_met_are_refused_before_any_work() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("out");
    let out = out.to_str().unwrap();
    for (order, told) in [
        ("dataset --maps synthetic:4294967295", "too many"),
        ("dataset --tx-per-map 0", "at least 1 transmitter"),
        ("dataset --threads 20000", "--threads 20000"),
        (
            "label --paths none.json --pdp OUT",
            "--out and --pdp are both",
        ),
    ] {
        let order = order.split(' ').map(|word| match word {
            "OUT" => out,
            word => word,
        });
        let found = fail(&order.chain(["--out", out]).collect::<Vec<_>>());
        assert!(found.contains(told), "{found}");
        assert!(!root.path().join("out").exists());
    }
}
