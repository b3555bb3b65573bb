//! A city in GeoJSON: maps of it are traced and labelled like others.

use std::fs;

use aps_data::Dataset;

use crate::folder::Folder;
use crate::{assert_told, fail, remarks, succeed};

pub const HELSINKI: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../tests/data/helsinki.geojson"
);

#[test]
fn helsinki_becomes_a_data_set() {
    let folder = Folder::new();
    let line = |out: &str, more: &str| {
        let out = folder.arg(out);
        format!("dataset --maps '{HELSINKI}' --profile smoke --map-ids 0,2 --out {out} {more}")
    };
    let told = remarks(&line("data", ""));
    assert_told(&told, &["75 buildings", "tiles of 256 m"]);

    let dataset = Dataset::open(folder.path("data")).unwrap();
    assert_eq!(dataset.verify().len(), 0);
    let maps = &dataset.manifest().configuration["maps"];
    assert_eq!(
        (maps["kind"].as_str(), maps["tile_m"].as_f64()),
        (Some("geojson"), Some(256.0))
    );
    assert_eq!(dataset.manifest().totals.maps, 2);
    for entry in &dataset.manifest().maps {
        let map = dataset.map(entry.id).unwrap();
        let built = map.buildings.pixels().iter().filter(|&&p| p == 1).count();
        assert!((5_000..60_000).contains(&built), "{built} pixels");
        assert!(map.valid_links().count() > 40);
    }

    // Another cut of the same city is another data set.
    assert_told(&fail(&line("data", "--tile 200")), &["tile_m"]);

    succeed(&line("again", "--threads 1"));
    let manifest = |name| fs::read(folder.path(name).join("manifest.json")).unwrap();
    assert_eq!(manifest("data"), manifest("again"));
}

#[test]
fn maps_that_a_profile_leaves_out_are_told() {
    let (folder, maps) = Folder::with_maps(3);
    let line = |out: &str, more: &str| {
        let out = folder.arg(out);
        let few = "--profile smoke --tx-per-map 1 --rx-per-map 3";
        remarks(&format!("dataset {few} --maps {maps} --out {out} {more}"))
    };
    assert_told(
        &line("some", ""),
        &["2 of 3 maps (profile smoke); --profile full or --map-ids for others"],
    );
    let told = line("all", "--map-ids 0-2");
    assert!(!told.contains("profile"), "{told}");
}

#[test]
fn link_in_a_tile_is_traced_and_drawn() {
    let folder = Folder::new();
    let svg = folder.arg("link.svg");
    let table = succeed(&format!(
        "trace --map '{HELSINKI}' --map-id 2 --tx 169,247 --rx 186,166 --limits r2d1 --svg {svg}"
    ));
    assert!(table.contains("54 paths"), "{table}");
    assert!(fs::read_to_string(svg).unwrap().contains("<svg"));
}

#[test]
fn cities_without_maps_are_explained() {
    let folder = Folder::new();
    let (city, out) = (folder.arg("city.geojson"), folder.arg("data"));
    let refused = |more: &str| fail(&format!("dataset --maps {city} --out {out} {more}"));
    assert!(refused("").contains("city.geojson"));
    fs::write(&city, "{").unwrap();
    assert!(refused("").contains("not valid GeoJSON"));
    let bare = r#"{"type":"Polygon","coordinates":[[[24.945,60.168],[24.946,60.168],[24.946,60.1685],[24.945,60.168]]]}"#;
    fs::write(&city, bare).unwrap();
    assert_told(&refused(""), &["`building` tag", "--all-polygons"]);
    let error = refused("--all-polygons --min-buildings 5");
    assert!(error.contains("no tile has 5 buildings"), "{error}");
}
