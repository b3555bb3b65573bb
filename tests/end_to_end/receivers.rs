//! Receivers are drawn among the points that a transmitter reaches, as in published data, or anywhere outdoors.

use std::collections::BTreeSet;
use std::fs;

use aps_data::{Dataset, MapData};

use crate::folder::Folder;
use crate::{assert_told, succeed};

/// Makes a data set of one map with limits so low that many points are out of reach.
fn make(folder: &Folder, maps: &str, out: &str, [tx, rx]: [u32; 2], more: &str) -> String {
    let limits = "--max-reflections 1 --max-diffractions 0 --max-fallback-diffractions 0";
    let sizes = format!("--tx-per-map {tx} --rx-per-map {rx} --store aps,paths");
    folder.make(
        out,
        &["--profile smoke", limits, &sizes, "--maps", maps, more],
    )
}

fn map(folder: &Folder, data: &str) -> MapData {
    Dataset::open(folder.path(data)).unwrap().map(0).unwrap()
}

/// A house around a yard, and houses elsewhere.
fn maps_with_yard(folder: &Folder) -> String {
    fs::create_dir(folder.path("maps")).unwrap();
    let wall = |x: [u32; 2], y: [u32; 2]| {
        let ([a, b], [c, d]) = (x, y);
        format!("[[{a},{c}],[{b},{c}],[{b},{d}],[{a},{d}]]")
    };
    // Only the yard, 10 m x 10 m, and a strip outside are free of buildings.
    let text = [
        wall([0, 100], [0, 20]),
        wall([0, 100], [30, 256]),
        wall([0, 20], [20, 30]),
        wall([30, 100], [20, 30]),
        wall([104, 256], [0, 256]),
    ];
    fs::write(folder.path("maps/0.json"), format!("[{}]", text.join(","))).unwrap();
    folder.arg("maps")
}

#[test]
fn each_transmitter_has_the_first_points_it_reaches() {
    let (folder, maps) = Folder::with_maps(1);
    let said = make(&folder, &maps, "reached", [6, 40], "--threads 1");
    assert_told(&said, &["100.000 %", "not reached"]);
    let reached = map(&folder, "reached");
    assert_eq!((reached.links.len(), reached.rx_m.len()), (240, 160));
    assert!(reached.links.is_sorted() && reached.status.iter().all(|s| s.is_valid()));
    let of_tx = |tx| -> BTreeSet<u32> {
        let links = reached.links.iter().filter(|l| l[0] == tx);
        links.map(|l| l[1]).collect()
    };
    assert!((0..6).all(|tx| of_tx(tx).len() == 40));
    assert!((1..6).any(|tx| of_tx(tx) != of_tx(0)));

    // The points passed over are just those without a path.
    make(&folder, &maps, "all", [6, 160], "--receivers outdoor");
    let all = map(&folder, "all");
    assert_eq!((&all.tx_m, &all.rx_m), (&reached.tx_m, &reached.rx_m));
    for tx in 0..6 {
        let with_path = (0..160).filter(|&rx| all.status[(160 * tx + rx) as usize].is_valid());
        assert!(with_path.take(40).eq(of_tx(tx)), "{tx}");
    }
}

#[test]
fn transmitter_that_reaches_too_few_has_fewer_links_and_the_reason_is_counted() {
    let folder = Folder::new();
    let maps = maps_with_yard(&folder);
    let said = make(&folder, &maps, "data", [40, 40], "");
    assert_told(&said, &["missing", "enclosed"]);
    let dataset = Dataset::open(folder.path("data")).unwrap();
    let entry = &dataset.manifest().maps[0];
    let missing = entry.statistics["missing_links"].as_u64().unwrap();
    assert!(missing > 0 && entry.links as u64 + missing == 40 * 40);
    let enclosed = &entry.statistics["points_not_reached"]["enclosed"];
    assert!(enclosed.as_u64().unwrap() > 0);
    let told = succeed(&format!("verify {} --maps {maps}", folder.arg("data")));
    assert!(told.contains("as it should be"), "{told}");
}

#[test]
fn points_with_chains_beyond_the_limits_alone_have_no_path_inside_them() {
    let (folder, maps) = Folder::with_maps(1);
    make(&folder, &maps, "plain", [4, 20], "");
    let limits = "--max-reflections 1 --max-diffractions 0 --max-fallback-diffractions 3";
    let sizes = "--tx-per-map 4 --rx-per-map 20 --store aps,paths";
    folder.make(
        "chains",
        &["--profile smoke", limits, sizes, "--maps", &maps],
    );
    let passed_over = |name| {
        let dataset = Dataset::open(folder.path(name)).unwrap();
        dataset.manifest().maps[0].statistics["points_not_reached"].clone()
    };
    assert!(passed_over("plain")["no_path"].as_u64().unwrap() > 0);
    assert_eq!(passed_over("plain"), passed_over("chains"));
}
