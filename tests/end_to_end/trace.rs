//! `trace`: the paths of a known place in every form.

use std::fs;

use serde_json::Value;

use crate::{fail, succeed, xtask};

/// One house, 20 m x 10 m; both terminals north of it.
fn house() -> (tempfile::TempDir, String) {
    let root = tempfile::tempdir().unwrap();
    let file = root.path().join("house.json");
    fs::write(
        &file,
        "[[[100,100],[120,100],[120,110],[100,110],[100,100]]]",
    )
    .unwrap();
    let name = file.to_str().unwrap().to_owned();
    (root, name)
}

#[test]
fn json_names_walls_points_and_angles() {
    let (_root, map) = house();
    let args = [
        "trace",
        "--map",
        &map,
        "--tx",
        "100,120",
        "--rx",
        "120,120",
        "--max-diffractions",
        "0",
        "--format",
        "json",
    ];
    let json: Value = serde_json::from_str(&succeed(&args)).unwrap();
    let paths = json["links"][0]["paths"].as_array().unwrap();
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
    let args = [
        "trace",
        "--map",
        &map,
        "--tx",
        "90,105",
        "--rx",
        "110,130",
        "--max-reflections",
        "0",
        "--format",
        "json",
    ];
    let json: Value = serde_json::from_str(&succeed(&args)).unwrap();
    let kinds: Vec<&Value> = json["links"][0]["paths"]
        .as_array()
        .unwrap()
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
    let (root, map) = house();
    let svg = root.path().join("link.svg");
    let links = root.path().join("links.csv");
    fs::write(
        &links,
        "tx_x,tx_y,rx_x,rx_y\n90,120,130,121\n90,120,130,90\n",
    )
    .unwrap();
    let csv = succeed(&[
        "trace",
        "--map",
        &map,
        "--links",
        links.to_str().unwrap(),
        "--format",
        "csv",
        "--svg",
        svg.to_str().unwrap(),
    ]);
    assert!(csv.starts_with("link,tx_x"), "{csv}");
    assert!(csv.lines().any(|l| l.starts_with("1,")), "{csv}");
    let picture = fs::read_to_string(svg).unwrap();
    assert!(picture.starts_with("<svg") && picture.contains("Angle power spectrum"));
}

#[test]
fn a_refused_carrier_is_refused_without_a_remark() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("data");
    let out = out.to_str().unwrap();
    let told = fail(&["dataset", "--out", out, "--frequency-hz", "nan"]);
    assert!(!told.contains("note:"), "{told}");
}

#[test]
fn what_deserves_a_second_look_is_said_in_a_line() {
    let (_root, map) = house();
    let notes = |rx: &str, more: &[&str]| -> Vec<String> {
        let args = ["trace", "--map", &map, "--tx", "90,110", "--rx", rx];
        let output = xtask(&[&args, more].concat());
        assert!(output.status.success(), "{output:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        text.lines().map(Into::into).collect()
    };
    assert!(notes("90,120", &[]).is_empty());
    assert!(notes("90,120", &["--frequency-hz", "1e9"]).is_empty());
    assert!(notes("90,120", &["--frequency-hz", "3e11", "--material", "pec"]).is_empty());
    for frequency in ["923e6", "3e11"] {
        let told = notes("90,120", &["--frequency-hz", frequency]);
        assert!(told.len() == 1, "{told:?}");
        assert!(
            told[0].contains("ITU-R P.2040-3") && told[0].contains("1e9 to 1e11 Hz"),
            "{told:?}"
        );
    }
    let told = notes("90,110.0001", &[]);
    assert!(
        told.len() == 1 && told[0].contains("less than a wavelength"),
        "{told:?}"
    );
    assert!(notes("90,110.09", &[]).is_empty());
}

#[test]
fn terminals_in_the_wrong_place_are_named() {
    let (_root, map) = house();
    let error = fail(&["trace", "--map", &map, "--tx", "110,105", "--rx", "5,5"]);
    assert!(
        error.contains("transmitter") && error.contains("inside building 0"),
        "{error}"
    );
    let error = fail(&["trace", "--map", &map, "--tx", "5,5", "--rx", "110,110"]);
    assert!(
        error.contains("receiver") && error.contains("on wall"),
        "{error}"
    );
    let error = fail(&["trace", "--map", &map, "--tx", "5,5", "--rx", "5,5"]);
    assert!(error.contains("both at"), "{error}");
    let error = fail(&["trace", "--map", &map, "--tx", "5,5", "--rx", "300,5"]);
    assert!(error.contains("outside the area"), "{error}");
    let error = fail(&["trace", "--map", &map, "--tx", "5;5", "--rx", "3,5"]);
    assert!(error.contains("not a pair of numbers"), "{error}");
    assert!(fail(&["trace", "--map", &map]).contains("give a link"));
}

#[test]
fn limits_have_names_and_single_ones_can_be_changed() {
    let (_root, map) = house();
    let ends = ["trace", "--map", &map, "--tx", "90,105", "--rx", "110,130"];
    let paths = |more: &[&str]| {
        let json = succeed(&[&ends[..], &["--format", "json"], more].concat());
        let json: Value = serde_json::from_str(&json).unwrap();
        json["links"][0]["paths"].as_array().unwrap().clone()
    };
    assert_eq!(paths(&[]), paths(&["--limits", "r2d1"]));
    let converged = paths(&["--limits", "converged"]);
    assert_eq!(
        converged,
        paths(&[
            "--max-reflections",
            "5",
            "--max-diffractions",
            "2",
            "--dynamic-range-db",
            "30"
        ])
    );
    let gains = converged.iter().map(|p| p["gain_db"].as_f64().unwrap());
    let (weakest, strongest) = gains.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), g| {
        (a.min(g), b.max(g))
    });
    assert!(strongest - weakest <= 30.0);
}
