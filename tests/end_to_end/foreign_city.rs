//! Foreign map files: what they say is read, what they do not say is asked for, and nothing is guessed.

use std::fs;

use aps_data::Dataset;

use crate::city::HELSINKI;
use crate::folder::{Folder, assert_same, files, map, set_pixels};
use crate::{assert_told, fail, remarks, succeed};

/// Corners of three houses \[m\], west, south, width and height.
const HOUSES: [[f64; 4]; 3] = [
    [0.0, 0.0, 20.0, 10.0],
    [60.0, 40.0, 20.0, 30.0],
    [120.0, 10.0, 30.0, 20.0],
];

/// A house whose corners go through a function, as a feature of its own.
fn house([x, y, w, h]: [f64; 4], tags: &str, place: impl Fn(f64, f64) -> [f64; 2]) -> String {
    let corners = [(x, y), (x + w, y), (x + w, y + h), (x, y + h), (x, y)];
    let ring = corners.map(|(x, y)| place(x, y));
    format!(
        r#"{{"type":"Feature","properties":{tags},"geometry":{{"type":"Polygon","coordinates":[{ring:?}]}}}}"#
    )
}

const YES: &str = r#"{"building":"yes"}"#;

fn houses(place: impl Fn(f64, f64) -> [f64; 2]) -> Vec<String> {
    let houses = HOUSES.iter();
    houses.map(|&h| house(h, YES, &place)).collect()
}

/// Longitude and latitude about 60 degrees north, 20 degrees east, near enough for a test.
fn degrees(x: f64, y: f64) -> [f64; 2] {
    [20.0 + x / 55_800.0, 60.0 + y / 111_412.0]
}

/// Web Mercator coordinates of the same place.
fn web_mercator(x: f64, y: f64) -> [f64; 2] {
    let [longitude, latitude] = degrees(x, y).map(f64::to_radians);
    [longitude, latitude.tan().asinh()].map(|angle| angle * 6_378_137.0)
}

fn collection(features: &[String], crs: &str) -> String {
    let features = features.join(",");
    format!(r#"{{"type":"FeatureCollection",{crs}"features":[{features}]}}"#)
}

fn named(crs: &str) -> String {
    format!(r#""crs":{{"type":"name","properties":{{"name":"{crs}"}}}},"#)
}

/// The command that makes a small data set of a file.
fn make(maps: &str, out: &str) -> String {
    format!("dataset --profile smoke --tx-per-map 2 --rx-per-map 10 --maps '{maps}' --out {out}")
}

#[test]
fn reference_system_is_read_and_recorded() {
    let folder = Folder::new();
    let (city, out) = (folder.arg("city.geojson"), folder.arg("data"));
    let mut pixels = Vec::new();
    for (text, crs) in [
        (collection(&houses(degrees), ""), "OGC:CRS84"),
        (
            collection(&houses(web_mercator), &named("urn:ogc:def:crs:EPSG::3857")),
            "EPSG:3857",
        ),
    ] {
        fs::write(&city, text).unwrap();
        let _ = fs::remove_dir_all(&out);
        assert_told(&remarks(&make(&city, &out)), &["3 buildings", crs]);
        let dataset = Dataset::open(&out).unwrap();
        let maps = &dataset.manifest().configuration["maps"];
        assert_eq!(
            (maps["crs"].as_str(), maps["all_polygons"].as_bool()),
            (Some(crs), Some(false))
        );
        pixels.push(set_pixels(&dataset) as f64);
    }
    // 1400 m2, with the pixels that walls run through; Web Mercator's own metres make 5600.
    assert!(
        pixels.iter().all(|p| (1400.0..1700.0).contains(p)),
        "{pixels:?}"
    );
    assert!((pixels[0] / pixels[1] - 1.0).abs() < 0.02, "{pixels:?}");

    let feet = |x: f64, y: f64| [984_250.0 + 3.281 * x, 196_850.0 + 3.281 * y];
    fs::write(
        &city,
        collection(&houses(feet), &named("urn:ogc:def:crs:EPSG::2263")),
    )
    .unwrap();
    let error = fail(&make(&city, &folder.arg("feet")));
    assert_told(&error, &["EPSG::2263", "ogr2ogr"]);
}

#[test]
fn metres_are_asked_for() {
    let folder = Folder::new();
    let city = folder.arg("city.geojson");
    let refused = |features: &[String]| {
        fs::write(&city, collection(features, "")).unwrap();
        fail(&make(&city, &folder.arg("refused")))
    };
    for shift in [0.0, 400_000.0] {
        let error = refused(&houses(|x, y| [x + shift, y + shift]));
        assert_told(&error, &["feature ", "--metric"]);
    }
    let out = folder.arg("data");
    assert_told(&remarks(&(make(&city, &out) + " --metric")), &["metres"]);
    succeed(&format!("verify {out} --maps {city}"));
    // Latitude first, in Japan.
    let error = refused(&houses(|x, y| [35.6 + y / 111e3, 139.7 + x / 91e3]));
    assert_told(&error, &["no latitude", "swapped"]);
    // Kilometres.
    fs::write(&city, collection(&houses(|x, y| [x / 1e3, y / 1e3]), "")).unwrap();
    let error = fail(&(make(&city, &folder.arg("refused")) + " --metric"));
    assert!(error.contains("another unit"), "{error}");
}

#[test]
fn same_city_comes_in_many_wrappings() {
    let folder = Folder::new();
    let houses = houses(degrees);
    let whole = collection(&houses, "");
    let bytes = |text: &str| text.as_bytes().to_vec();
    let tagged = |h, tags| house(h, tags, degrees);
    let nested = [
        tagged(HOUSES[0], r#"{"id":1,"tags":{"building":"yes"}}"#),
        houses[1].clone(),
        tagged([0.0, 0.0, 150.0, 80.0], r#"{"tags":{"landuse":"residential"}}"#),
        tagged(HOUSES[2], YES),
        tagged([20.0, 60.0, 10.0, 10.0], r#"{"building":"construction"}"#),
        r#"{"type":"Feature","properties":{"building":"yes"},"geometry":{"type":"MultiPolygon","coordinates":[[]]}}"#.into(),
    ];
    let variants = [
        ("city.geojson", bytes(&whole)),
        ("city.json", bytes(&whole)),
        (
            "mark.geojson",
            [&b"\xef\xbb\xbf"[..], whole.as_bytes()].concat(),
        ),
        ("lines.geojsonl", bytes(&houses.join("\n"))),
        (
            "sequence.geojsons",
            bytes(
                &houses
                    .iter()
                    .map(|h| format!("\u{1e}{h}\n"))
                    .collect::<String>(),
            ),
        ),
        (
            "collections.geojson",
            bytes(
                &houses
                    .iter()
                    .map(|h| collection(std::slice::from_ref(h), ""))
                    .collect::<String>(),
            ),
        ),
        ("nested.geojson", bytes(&collection(&nested, ""))),
    ];
    let arrays = |name: &str| {
        let mut found = files(&folder.path(name));
        found.retain(|name, _| name.ends_with(".npy"));
        found
    };
    for (name, text) in variants {
        fs::write(folder.path(name), text).unwrap();
        let out = format!("data-{name}");
        let words = remarks(&make(&folder.arg(name), &folder.arg(&out)));
        assert!(words.contains("3 buildings about"), "{name}: {words}");
        if name == "nested.geojson" {
            let parts = [
                "1 feature that is no building",
                "1 building planned, under construction",
                "1 building without an area",
            ];
            assert_told(&words, &parts);
        }
        assert_same(&arrays("data-city.geojson"), &arrays(&out));
    }
    let wide: Vec<u8> = whole.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let with_nan = whole.replace("\"yes\"", "\"yes\",\"height\":NaN");
    for (text, expected) in [
        (wide, "UTF-16"),
        (bytes(&with_nan), "NaN at line 1 column"),
        (Vec::new(), "the file is empty"),
        (bytes(&map(0)), "--map-ids"),
    ] {
        fs::write(folder.path("bad.geojson"), text).unwrap();
        let error = fail(&make(&folder.arg("bad.geojson"), &folder.arg("bad")));
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn folders_are_read_as_they_are_or_not_at_all() {
    let (folder, maps) = Folder::with_maps(1);
    fs::rename(folder.path("maps/0.json"), folder.path("maps/000.json")).unwrap();
    fs::write(folder.path("maps/010.json"), format!("\u{feff}{}", map(1))).unwrap();
    let out = folder.arg("data");
    succeed(&make(&maps, &out));
    let dataset = Dataset::open(&out).unwrap();
    let ids: Vec<u32> = dataset.manifest().maps.iter().map(|m| m.id).collect();
    assert_eq!(ids, [0, 10]);
    succeed(&format!("verify {out} --maps {maps}"));

    fs::write(folder.path("maps/10.json"), map(2)).unwrap();
    let error = fail(&make(&maps, &folder.arg("two")));
    assert!(error.contains("10.json and 010.json"), "{error}");
    assert!(fail(&format!("verify {out} --maps {maps}")).contains("two files of map 10"));
    fs::remove_file(folder.path("maps/10.json")).unwrap();

    for (text, expected) in [
        ("[]", "no building"),
        ("[[[0,0],[0.2,0],[0.2,0.1]]]", "another unit"),
        (
            "[[[385000,6671000],[385020,6671000],[385020,6671010]]]",
            "no building in the square",
        ),
        (
            r#"{"type":"FeatureCollection","features":[]}"#,
            "not GeoJSON",
        ),
    ] {
        fs::write(folder.path("maps/000.json"), text).unwrap();
        let error = fail(&make(&maps, &folder.arg("bad")));
        assert_told(&error, &["000.json", expected]);
    }
}

#[test]
fn pictures_and_checks_cut_the_city_as_the_data_set_has_it() {
    let folder = Folder::new();
    let (city, out) = (folder.arg("city.geojson"), folder.arg("data"));
    let untagged: Vec<String> = HOUSES
        .iter()
        .map(|&h| house(h, "{}", |x, y| [x, y]))
        .collect();
    fs::write(&city, collection(&untagged, "")).unwrap();
    let settings = "--tile 90 --metric --all-polygons";
    remarks(&format!("{} {settings}", make(&city, &out)));
    let page = folder.arg("page.html");

    let told = succeed(&format!("verify {out} --maps {city}"));
    assert!(told.contains("links computed anew"), "{told}");
    succeed(&format!("gallery {out} --out {page}"));
    succeed(&format!("gallery {out} --maps {city} --out {page}"));
    let dataset = Dataset::open(&out).unwrap();
    let map = dataset.map(dataset.manifest().maps[0].id).unwrap();
    let [tx, rx] = map.links[map.valid_links().next().unwrap()];
    let link = format!("{},{tx},{rx}", map.id);
    let explain = format!("explain {out} --link {link} --out {page}");
    assert_told(&fail(&explain), &["--maps FILE.geojson"]);
    succeed(&format!("{explain} --maps {city}"));
    let error = fail(&format!("{explain} --maps {city} --tile 50"));
    assert!(error.contains("was made of maps"), "{error}");
    assert!(succeed(&format!("verify {out}")).contains("--maps FILE.geojson"));

    let one = format!("--map {city} --tx 30,5 --rx 40,60 {settings}");
    succeed(&format!("explain --out {page} {one}"));
    succeed(&format!("trace {one}"));
}

#[test]
fn corner_of_the_first_map_can_be_given() {
    let folder = Folder::new();
    let (city, out) = (folder.arg("city.geojson"), folder.arg("data"));
    fs::write(&city, collection(&houses(degrees), "")).unwrap();
    let [longitude, latitude] = degrees(-10.0, -20.0);
    let corner = format!("--corner {longitude},{latitude}");
    let words = remarks(&format!("{} {corner}", make(&city, &out)));
    assert!(words.contains("3 buildings"), "{words}");
    let dataset = Dataset::open(&out).unwrap();
    let manifest = dataset.manifest();
    let maps = &manifest.configuration["maps"];
    assert_eq!(maps["corner"], serde_json::json!([longitude, latitude]));
    // The first house has its corner 10 m east and 20 m north of the map's.
    let buildings = dataset.map(manifest.maps[0].id).unwrap().buildings;
    let [x, y] = [10.0, 20.0];
    let is_built = |x: f64, y: f64| buildings.pixels()[y as usize * 256 + x as usize] == 1;
    assert!(
        is_built(x + 1.5, y + 1.5) && !is_built(x - 1.5, y + 1.5) && !is_built(x + 1.5, y - 1.5)
    );
    succeed(&format!("verify {out} --maps {city}"));
    let error = fail(&format!("verify {out} --maps {city} --corner 20,60"));
    assert!(error.contains("was made of maps"), "{error}");
    for (corner, word) in [
        ("20,95", "origin"),
        ("0,0", "degrees from"),
        ("21,61", "no tile has"),
    ] {
        let error = fail(&format!(
            "{} --corner {corner}",
            make(&city, &folder.arg("no"))
        ));
        assert!(error.contains(word), "{error}");
    }
}

#[test]
fn settings_of_tiles_are_refused_beside_maps_that_are_not_cut() {
    let (folder, maps) = Folder::with_maps(1);
    let out = folder.arg("data");
    for command in [
        format!("dataset --maps synthetic:2 --tile 200 --out {out}"),
        format!("dataset --maps {maps} --metric --out {out}"),
        "trace --map synthetic --min-buildings 2 --tx 45,75 --rx 122,80".into(),
    ] {
        let told = fail(&command);
        assert!(told.contains("are for a city in GeoJSON"), "{told}");
    }
    assert!(!folder.path("data").exists());
}

#[test]
fn manifests_that_say_less_are_still_read() {
    let folder = Folder::new();
    let out = folder.arg("data");
    succeed(&(make(HELSINKI, &out) + " --map-ids 0 --tile 200"));
    let is_old = |line: &&str| !line.contains("\"crs\":") && !line.contains("\"all_polygons\":");
    for manifest in ["data/manifest.json", "data/map_0000/map.json"] {
        let text = fs::read_to_string(folder.path(manifest)).unwrap();
        let older: String = text.split_inclusive('\n').filter(|l| is_old(l)).collect();
        assert_eq!(older.lines().count() + 2, text.lines().count());
        fs::write(folder.path(manifest), older).unwrap();
    }
    let page = folder.arg("page.html");
    let told = succeed(&format!("gallery {out} --maps '{HELSINKI}' --out {page}"));
    assert!(told.contains("12 links"), "{told}");
    succeed(&format!("info {out}"));
}
