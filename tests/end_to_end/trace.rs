//! `trace`: the paths of a known place in every form.

use std::fs;

use serde_json::Value;

use crate::folder::Folder;
use crate::{assert_told, fail, remarks, succeed};

/// A folder with one house, 20 m x 10 m, and the map's name; the terminals are north of it.
fn house() -> (Folder, String) {
    let folder = Folder::new();
    let map = folder.arg("house.json");
    fs::write(
        &map,
        "[[[100,100],[120,100],[120,110],[100,110],[100,100]]]",
    )
    .unwrap();
    (folder, map)
}

/// The paths of the first link.
fn paths(trace: &str) -> Vec<Value> {
    let json: Value = serde_json::from_str(&succeed(&format!("{trace} --format json"))).unwrap();
    json["links"][0]["paths"].as_array().unwrap().clone()
}

#[test]
fn json_names_walls_points_and_angles() {
    let (_root, map) = house();
    let paths = paths(&format!(
        "trace --map {map} --tx 100,120 --rx 120,120 --max-diffractions 0"
    ));
    assert_eq!(paths.len(), 2);
    assert_eq!(paths[0]["length_m"], 20.0);
    assert_eq!(paths[0]["departure_azimuth_rad"], 0.0);
    assert_eq!(paths[0]["arrival_azimuth_rad"], std::f64::consts::PI);
    let bounce = &paths[1]["interactions"][0];
    assert_eq!(bounce["kind"], "reflection");
    assert_eq!(bounce["point"][0], 110.0);
    assert_eq!(bounce["point"][1], 110.0);
    assert!((paths[1]["length_m"].as_f64().unwrap() - 20.0 * 2.0_f64.sqrt()).abs() < 1e-12);
    // From the receiver down to the left, towards the point of reflection.
    let arrival = paths[1]["arrival_azimuth_rad"].as_f64().unwrap();
    assert!((arrival + 0.75 * std::f64::consts::PI).abs() < 1e-12);
}

#[test]
fn diffraction_names_its_corner() {
    let (_root, map) = house();
    let paths = paths(&format!(
        "trace --map {map} --tx 90,105 --rx 110,130 --limits r2d1 --max-reflections 0"
    ));
    let kinds: Vec<&Value> = paths
        .iter()
        .flat_map(|p| p["interactions"].as_array().unwrap())
        .collect();
    assert!(!kinds.is_empty());
    for i in kinds {
        assert_eq!(i["kind"], "diffraction");
        assert!(i["corner"].is_u64() && i.get("wall").is_none());
    }
}

#[test]
fn picture_and_csv_are_made() {
    let (folder, map) = house();
    let (svg, links) = (folder.arg("link.svg"), folder.arg("links.csv"));
    fs::write(
        &links,
        "tx_x,tx_y,rx_x,rx_y\n90,120,130,121\n90,120,130,90\n",
    )
    .unwrap();
    let csv = succeed(&format!(
        "trace --map {map} --links {links} --format csv --svg {svg}"
    ));
    assert!(csv.starts_with("link,tx_x"), "{csv}");
    assert!(csv.lines().any(|l| l.starts_with("1,")), "{csv}");
    let both = fail(&format!("trace --map {map} --links {links} --rx 2,2"));
    assert_told(&both, &["--links", "cannot be used with", "--rx"]);
    let picture = fs::read_to_string(svg).unwrap();
    assert!(picture.starts_with("<svg") && picture.contains("Angle power spectrum"));
}

#[test]
fn folders_of_pictures_are_made_and_are_no_pictures() {
    let (folder, map) = house();
    let trace = format!("trace --map {map} --tx 100,120 --rx 120,120 --svg");
    let new = folder.arg("a/b/link.svg");
    succeed(&format!("{trace} {new}").replace("--map ", "--maps "));
    assert!(fs::metadata(new).unwrap().is_file());
    assert_told(
        &fail(&format!("{trace} {}", folder.arg("a"))),
        &["is a folder"],
    );
}

#[test]
fn a_refused_carrier_is_refused_without_a_remark() {
    let folder = Folder::new();
    let out = folder.arg("data");
    let told = fail(&format!("dataset --out {out} --frequency-hz nan"));
    assert!(!told.contains("note:"), "{told}");
}

#[test]
fn what_deserves_a_second_look_is_said_in_a_line() {
    let (_root, map) = house();
    let notes = |rx: &str| -> Vec<String> {
        let text = remarks(&format!("trace --map {map} --tx 90,110 --rx {rx}"));
        text.lines().map(Into::into).collect()
    };
    assert!(notes("90,120").is_empty());
    assert!(notes("90,120 --frequency-hz 1e9").is_empty());
    assert!(notes("90,120 --frequency-hz 3e11 --material pec").is_empty());
    for frequency in ["923e6", "3e11"] {
        let told = notes(&format!("90,120 --frequency-hz {frequency}"));
        assert!(told.len() == 1, "{told:?}");
        assert_told(&told[0], &["ITU-R P.2040-3", "1e9 to 1e11 Hz"]);
    }
    let told = notes("90,110.0001");
    assert!(told.len() == 1, "{told:?}");
    assert_told(&told[0], &["less than a wavelength"]);
    assert!(notes("90,110.09").is_empty());
}

#[test]
fn terminals_in_the_wrong_place_are_named() {
    let (_root, map) = house();
    let cases: [(&str, &[&str]); 6] = [
        (
            "--tx 110,105 --rx 5,5",
            &["transmitter", "inside building 0"],
        ),
        ("--tx 5,5 --rx 110,110", &["receiver", "on wall"]),
        ("--tx 5,5 --rx 5,5", &["both at"]),
        ("--tx 5,5 --rx 300,5", &["outside the area"]),
        ("--tx 5;5 --rx 3,5", &["not a pair of numbers"]),
        ("", &["give a link"]),
    ];
    for (ends, told) in cases {
        assert_told(&fail(&format!("trace --map {map} {ends}")), told);
    }
}

#[test]
fn limits_have_names_and_single_ones_can_be_changed() {
    let ends = "trace --map synthetic --tx 63,175 --rx 151,57";
    let paths = |limits: &str| paths(&format!("{ends} {limits}"));
    let (converged, r2d1) = (paths(""), paths("--limits r2d1"));
    assert!(converged.len() > 1 && r2d1.len() > 1 && converged != r2d1);
    assert_eq!(converged, paths("--limits converged"));
    let single = "--max-reflections 5 --max-diffractions 2 --dynamic-range-db 20";
    assert_eq!(converged, paths(&format!("--limits r2d1 {single}")));
    let single = "--max-reflections 2 --max-diffractions 1 --dynamic-range-db 60";
    assert_eq!(r2d1, paths(single));
    let gains = converged.iter().map(|p| p["gain_db"].as_f64().unwrap());
    let (weakest, strongest) = gains.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), g| {
        (a.min(g), b.max(g))
    });
    assert!(strongest - weakest <= 20.0);
}
