//! `label`: what `trace` writes becomes the same labels that the crate computes.

use std::f64::consts::PI;
use std::fs;

use aps_label::{LabelConfig, Labeler, PathSample};

use crate::folder::Folder;
use crate::{assert_told, fail, succeed};

#[test]
fn foreign_paths_become_labels() {
    let folder = Folder::new();
    let [paths, aps, pdp] = ["paths.json", "aps.npy", "pdp.npy"].map(|name| folder.arg(name));
    fs::write(
        &paths,
        r#"{"links": [{"paths": [
            {"delay_s": 1.5e-7, "arrival_azimuth_rad": 0.5, "gain_db": -80.0},
            {"delay_s": 2.5e-7, "arrival_azimuth_rad": -2.0, "gain_db": -90.0}]}]}"#,
    )
    .unwrap();
    succeed(&format!(
        "label --paths {paths} --protocol released --out {aps} --pdp {pdp}"
    ));

    let told = fail(&format!("label --paths {paths} --out {paths}"));
    assert!(told.contains("holds the paths"), "{told}");

    let read = |path| {
        let npy =
            npyz::NpyFile::new(std::io::BufReader::new(fs::File::open(path).unwrap())).unwrap();
        let shape = npy.shape().to_vec();
        (shape, npy.into_vec::<f64>().unwrap())
    };
    let (shape, values) = read(&aps);
    assert_eq!(shape, [1, 180]);
    assert_eq!(read(&pdp).0, [1, 128]);
    let samples = [(1.5e-7, 0.5, -80.0), (2.5e-7, -2.0, -90.0)].map(
        |(delay_s, arrival_azimuth_rad, gain_db)| PathSample {
            delay_s,
            arrival_azimuth_rad,
            gain_db,
        },
    );
    let labeler = Labeler::new(&LabelConfig::released()).unwrap();
    let expected = labeler.label(&samples).unwrap().unwrap();
    assert_eq!(values, expected.aps_db);
    // The released angle is the direction of travel.
    let strongest = (0..180)
        .max_by(|&i, &j| values[i].total_cmp(&values[j]))
        .unwrap();
    let angle = (-180.0 + 360.0 / 179.0 * strongest as f64).to_radians();
    assert!((angle.sin() - (0.5 + PI).sin()).abs() < 0.03);
}

#[test]
fn bad_lists_are_told() {
    let folder = Folder::new();
    let (paths, out) = (folder.arg("paths.json"), folder.path("aps.npy"));
    let line = format!("label --paths {paths} --out {}", folder.arg("aps.npy"));
    let run = |text: &str| {
        fs::write(&paths, text).unwrap();
        fail(&line)
    };
    let list = |path: &str| format!(r#"{{"links": [{{"paths": [{path}]}}]}}"#);
    assert!(run("[]").contains("expected"), "shape");
    assert!(run(&list("")).contains("no path"), "empty");
    // A number that is none, as Python's json writes it: link, path and field are named, and a way out.
    let good = r#"{"delay_s": 2e-7, "arrival_azimuth_rad": 0.5, "gain_db": -90}"#;
    let second = |path: &str| {
        let links = format!(r#"{{"paths": [{good}]}}, {{"paths": [{good}, {path}]}}"#);
        run(&format!(r#"{{"links": [{links}]}}"#))
    };
    for value in ["-Infinity", "NaN", "null"] {
        let told = second(&good.replace("-90", value));
        assert!(told.contains("links[1].paths[1].gain_db"), "{told}");
        assert!(told.contains("leave out a path that has no gain"), "{told}");
    }
    for value in ["135.0", "-1e9", "6.4"] {
        let told = second(&good.replace("0.5", value));
        assert_told(&told, &["link 1: path 1: arrival_azimuth_rad"]);
        assert!(told.contains("are the units radians?"), "{told}");
    }
    let told = run(&format!("{0}\n{0}", list(good)));
    assert!(told.contains("one list a file"), "{told}");
    let negative = list(r#"{"delay_s": -1, "arrival_azimuth_rad": 0, "gain_db": -80}"#);
    assert!(run(&negative).contains("link 0"), "delay");
    assert!(!out.exists());
    for azimuth in ["6.283185307179587", "-6.28"] {
        fs::write(&paths, list(&good.replace("0.5", azimuth))).unwrap();
        succeed(&line);
    }
}
