//! The image, the walls and the labels of a data set are of one city, and its settings say how the city was made.

use std::fs;

use aps_data::Dataset;

use crate::folder::{Folder, set_pixels};
use crate::{fail, succeed};

/// Makes a small data set of a file or folder; returns what was said and the set pixels of its images.
fn make(folder: &Folder, maps: &str, out: &str, more: &str) -> (String, usize) {
    let settings = "--profile smoke --tx-per-map 3 --rx-per-map 30 --maps";
    let said = folder.make(out, &[settings, maps, more]);
    let dataset = Dataset::open(folder.path(out)).unwrap();
    (said, set_pixels(&dataset))
}

/// A city in metres whose one building has these rings.
fn city(folder: &Folder, name: &str, rings: &str) -> String {
    let text = format!(
        r#"{{"type": "FeatureCollection", "features": [
            {{"type": "Feature", "properties": {{"building": "yes"}}, "geometry": {{"type": "Polygon", "coordinates": {rings}}}}},
            {{"type": "Feature", "properties": {{"building": "yes"}}, "geometry": {{"type": "Polygon",
                "coordinates": [[[500150, 150], [500155, 150], [500155, 155], [500150, 155], [500150, 150]]]}}}}]}}"#
    );
    fs::write(folder.path(name), text).unwrap();
    folder.arg(name)
}

fn square(low: i32, high: i32) -> String {
    let [low, high] = [low, high].map(|v| v + 500_000);
    let y = |x: i32| x - 500_000;
    format!(
        "[[{low},{0}],[{high},{0}],[{high},{1}],[{low},{1}],[{low},{0}]]",
        y(low),
        y(high)
    )
}

#[test]
fn holes_in_any_place_are_drawn_as_they_are_traced() {
    let folder = Folder::new();
    let yard = city(
        &folder,
        "yard.geojson",
        &format!("[{},{}]", square(20, 70), square(30, 60)),
    );
    let (_, right) = make(&folder, &yard, "yard", "--metric");
    let swapped = city(
        &folder,
        "swapped.geojson",
        &format!("[{},{}]", square(30, 60), square(20, 70)),
    );
    let (said, found) = make(&folder, &swapped, "swapped", "--metric");
    assert_eq!(found, right);
    assert!(said.contains("1 hole taken for an outer ring"), "{said}");
    let shapes = [
        (
            "beside",
            format!("[{},{}]", square(20, 70), square(100, 140)),
            51 * 51,
        ),
        (
            "over",
            format!("[{},{},{}]", square(20, 90), square(30, 60), square(50, 80)),
            0,
        ),
    ];
    for (name, rings, house) in shapes {
        let file = city(&folder, &format!("{name}.geojson"), &rings);
        let (_, set) = make(&folder, &file, name, "--metric");
        // 6 x 6 pixels are the small house.
        assert!(house == 0 || set == house + 36, "{name}: {set}");
        let whole = succeed(&format!(
            "verify {} --maps {file} --sample 20",
            folder.arg(name)
        ));
        assert!(whole.contains("is as it should be"), "{name}: {whole}");
    }
}

#[test]
fn slit_is_closed_unless_told_otherwise_and_verify_knows() {
    let folder = Folder::new();
    fs::create_dir(folder.path("maps")).unwrap();
    let house =
        |left: f64, right: f64| format!("[[{left},100],[{right},100],[{right},120],[{left},120]]");
    let text = format!("[{},{}]", house(40.0, 120.0), house(120.01, 200.0));
    fs::write(folder.path("maps/0.json"), text).unwrap();
    let maps = folder.arg("maps");
    let (said, _) = make(&folder, &maps, "closed", "");
    assert!(said.contains("1 map repaired: 1 gap closed"), "{said}");
    let (said, _) = make(&folder, &maps, "open", "--close-gaps 0");
    assert!(!said.contains("gap"), "{said}");
    for (data, width_m) in [("closed", 0.04), ("open", 0.0)] {
        succeed(&format!("verify {} --maps {maps}", folder.arg(data)));
        let dataset = Dataset::open(folder.path(data)).unwrap();
        assert_eq!(
            dataset.manifest().configuration["scene"]["close_gaps_m"],
            width_m
        );
    }
    let map = folder.arg("maps/0.json");
    let limits = "--tx 120.005,60 --rx 120.005,180 --max-reflections 0";
    let through = format!("trace --map {map} {limits}");
    assert!(!succeed(&through).contains("  LoS"));
    assert!(succeed(&format!("{through} --close-gaps 0")).contains("  LoS"));
    let error = fail(&format!("{through} --close-gaps=-1"));
    assert!(error.contains("no width in metres"), "{error}");
}
