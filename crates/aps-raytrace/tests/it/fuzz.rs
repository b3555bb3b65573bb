//! The GeoJSON reader fed with texts, most of them a good one with bytes changed: it returns a city whose
//! numbers are finite, or an error, and what it returns is no larger than the text.

#![cfg(feature = "geojson")]

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Coordinates, GeoJsonConfig, Tiling, parse_geojson};
use aps_raytrace::{Footprint, Scene};
use proptest::prelude::*;
use proptest::sample::Index;

const CITY: &str = r#"{"type":"FeatureCollection","features":[
{"type":"Feature","properties":{"building":"yes","layer":"1"},"geometry":{"type":"Polygon","coordinates":
[[[24.945,60.168],[24.946,60.168],[24.946,60.1685],[24.945,60.1685],[24.945,60.168]],
[[24.9452,60.1681],[24.9458,60.1681],[24.9458,60.1684],[24.9452,60.1681]]]}},
{"type":"Feature","properties":{"building":"no"},"geometry":{"type":"Point","coordinates":[24.9,60.1]}},
{"type":"Feature","properties":{"building":7},"geometry":{"type":"GeometryCollection","geometries":[
{"type":"MultiPolygon","coordinates":[[[[24.947,60.168,3],[24.9475,60.168],[24.947,60.169]]]]}]}}]}"#;

/// A city in Web Mercator, one feature a line, with records marked as RFC 8142 has it.
const LINES: &str = "\u{feff}\u{1e}{\"type\":\"Feature\",\"crs\":{\"type\":\"name\",\"properties\":{\"name\":\"EPSG:3857\"}},\
    \"properties\":{\"tags\":{\"building\":\"yes\"}},\"geometry\":{\"type\":\"MultiPolygon\",\"coordinates\":\
    [[],[[[2776865,8439135],[2776976,8439135],[2776976,8439247]],[]]]}}\n\
    \u{1e}{\"type\":\"Feature\",\"crs\":{\"type\":\"EPSG\",\"properties\":{\"code\":3857}},\
    \"properties\":{\"building\":\"ruins\"},\"geometry\":null}\n";

fn read_all_ways(text: impl AsRef<[u8]>) {
    let text = text.as_ref();
    for coordinates in [Coordinates::Degrees, Coordinates::Metres] {
        let config = GeoJsonConfig {
            coordinates,
            all_polygons: text.len().is_multiple_of(2),
            origin: text.len().is_multiple_of(3).then_some([24.94, 60.16]),
        };
        let Ok(city) = parse_geojson(text, &config) else {
            continue;
        };
        let vertices = city
            .footprints
            .iter()
            .flat_map(|f| std::iter::once(&f.outer).chain(&f.holes));
        let vertices: Vec<_> = vertices.flatten().collect();
        assert!(vertices.iter().all(|p| p.is_finite()));
        assert!(vertices.len() <= text.len());
        let Ok(tiling) = Tiling::new(city.footprints, 256.0) else {
            continue;
        };
        // The scene is another matter: one city in four is enough for it.
        let tiles = if text.len().is_multiple_of(4) { 3 } else { 0 };
        for id in tiling.ids(1).take(tiles) {
            let tile = tiling.tile(id).expect("listed tiles are there");
            // Repair may refuse, but never panic.
            let _ = Scene::new(&tile.footprints, Some(tile.area));
        }
    }
}

/// The bytes of a text, some of them others.
fn changed(text: &str, changes: Vec<(Index, u8)>) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for (at, value) in changes {
        let at = at.index(bytes.len());
        bytes[at] = value;
    }
    bytes
}

/// Bytes that keep a text close to JSON.
fn likely_byte() -> impl Strategy<Value = u8> {
    prop::sample::select(b"0123456789-+eE.\"{}[],: nulyops".to_vec())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(1_000)))]

    #[test]
    fn good_text_with_bytes_changed(changes in prop::collection::vec((any::<Index>(), likely_byte()), 1..4)) {
        read_all_ways(changed(CITY, changes));
    }

    #[test]
    fn lines_with_bytes_changed_and_the_end_cut(
        changes in prop::collection::vec((any::<Index>(), prop_oneof![likely_byte(), any::<u8>()]), 0..3),
        end in any::<Index>(),
        is_cut in any::<bool>(),
    ) {
        let mut bytes = changed(LINES, changes);
        if is_cut {
            bytes.truncate(end.index(bytes.len()));
        }
        read_all_ways(bytes);
    }

    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..60)) {
        read_all_ways(bytes);
    }

    #[test]
    fn good_text_with_a_piece_moved(from in any::<Index>(), length in 1_usize..60, to in any::<Index>()) {
        let from = from.index(CITY.len());
        let piece = &CITY[from..CITY.len().min(from + length)];
        let to = to.index(CITY.len());
        read_all_ways([&CITY[..to], piece, &CITY[to..]].concat());
    }

    #[test]
    fn polygon_of_any_numbers(
        rings in prop::collection::vec(prop::collection::vec((any_number(), any_number()), 0..6), 0..4),
        kind in prop::sample::select(vec!["Polygon", "MultiPolygon", "LineString"]),
    ) {
        let ring = |points: &Vec<(f64, f64)>| {
            let points: Vec<String> = points.iter().map(|(x, y)| format!("[{x:e},{y:e}]")).collect();
            format!("[{}]", points.join(","))
        };
        let rings: Vec<String> = rings.iter().map(ring).collect();
        let coordinates = match kind {
            "MultiPolygon" => format!("[[{}]]", rings.join(",")),
            _ => format!("[{}]", rings.join(",")),
        };
        read_all_ways(format!(
            r#"{{"type":"Feature","properties":{{"building":true}},"geometry":{{"type":"{kind}","coordinates":{coordinates}}}}}"#
        ));
    }
}

/// Degrees near each other, whole metres, and whatever a double can be.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        60.0..60.001,
        (-300_i32..300).prop_map(f64::from),
        any::<f64>().prop_filter("JSON has no others", |x| x.is_finite()),
    ]
}

#[test]
fn building_that_is_all_courtyard_is_dropped() {
    let outer = [(60.0, 60.0), (0.0, 0.0), (0.0, 60.0)].map(DVec2::from);
    let around = [(0.0, 101.0), (0.0, 0.0), (166.0, 60.0)].map(DVec2::from);
    for (hole, walls) in [(outer, 0), (around, 5)] {
        let building = Footprint {
            holes: vec![hole.to_vec()],
            ..Footprint::new(outer)
        };
        let scene = Scene::new(&[building], None).unwrap();
        assert_eq!(scene.walls().len(), walls);
        assert!(!scene.report().is_clean());
    }
}

#[test]
fn texts_that_are_varied_are_good_ones() {
    for text in [CITY, LINES] {
        let city = parse_geojson(text, &GeoJsonConfig::default()).unwrap();
        assert!(!city.footprints.is_empty());
    }
}

#[test]
fn nesting_is_an_error_not_a_full_stack() {
    for piece in ["[", "{\"type\":\"GeometryCollection\",\"geometries\":["] {
        assert!(parse_geojson(piece.repeat(100_000), &GeoJsonConfig::default()).is_err());
    }
}
