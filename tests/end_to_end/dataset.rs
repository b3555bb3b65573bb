//! `dataset`: arrays that hold what they say, settings and mistakes.

use std::fs;

use aps_data::{Dataset, LinkStatus};

use crate::folder::Folder;
use crate::{assert_told, fail};

const SETTINGS: &str = "--profile smoke --store aps,pdp,paths";

#[test]
fn arrays_hold_what_they_say() {
    let folder = Folder::new();
    let summary = folder.make("data", &[SETTINGS]);
    assert!(summary.contains("links/s"), "{summary}");

    let dataset = Dataset::open(folder.path("data")).unwrap();
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
    let folder = Folder::new();
    folder.make("data", &[SETTINGS]);
    let out = folder.arg("data");
    let settings = format!("{SETTINGS} --max-reflections 1");
    let differences = [
        "configuration.trace.max_interactions is 7 there, 3 here",
        "configuration.trace.max_reflections is 5 there, 1 here",
    ];
    assert_told(
        &fail(&format!("dataset {settings} --out {out}")),
        &differences,
    );
}

#[test]
fn the_source_of_the_material_is_named() {
    let folder = Folder::new();
    let source = |name| {
        let dataset = Dataset::open(folder.path(name)).unwrap();
        let configuration = &dataset.manifest().configuration;
        configuration.pointer("/trace/material_source").cloned()
    };
    folder.make("data", &[SETTINGS]);
    assert_eq!(source("data"), Some("ITU-R P.2040-3, table 3".into()));
    folder.make("pec", &[SETTINGS, "--material pec"]);
    assert_eq!(source("pec"), None);
}

#[test]
fn mistakes_are_told() {
    let (folder, maps) = Folder::with_maps(0);
    let refused = |maps: &str| {
        let out = folder.arg("data");
        fail(&format!("dataset --maps {maps} --out {out}"))
    };

    assert_told(&refused(&maps), &["no map in"]);

    assert_told(&refused("/nowhere/at/all"), &["cannot read the maps"]);

    let map = folder.path("maps/0.json");
    fs::write(&map, "[[[0,0],[10,0],[10,\"x\"]]]").unwrap();
    assert_told(&refused(&maps), &["0.json", "building 0, vertex 2"]);

    fs::write(&map, "[[[0,0],[256,0],[256,256],[0,256]]]").unwrap();
    assert_told(&refused(&maps), &["outdoor grid points"]);

    let error = refused(&format!("{maps} --map-ids 0-3"));
    assert!(error.contains("[1, 2, 3] are not there"), "{error}");
}

#[test]
fn orders_that_cannot_be_met_are_refused_before_any_work() {
    let folder = Folder::new();
    let out = folder.arg("out");
    for (order, told) in [
        ("dataset --maps synthetic:4294967295", "too many"),
        ("dataset --tx-per-map 0", "at least 1 transmitter"),
        ("dataset --threads 20000", "--threads 20000"),
        (
            "label --paths none.json --pdp OUT",
            "--out and --pdp are both",
        ),
    ] {
        let order = order.replace("OUT", &out);
        assert_told(&fail(&format!("{order} --out {out}")), &[told]);
        assert!(!folder.path("out").exists());
    }
}
