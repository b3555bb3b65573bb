use super::*;

const SQUARE: &str =
    "[[24.945,60.168],[24.946,60.168],[24.946,60.1685],[24.945,60.1685],[24.945,60.168]]";
const YES: &str = r#""building":"yes""#;
const METRES: GeoJsonConfig = GeoJsonConfig {
    coordinates: Coordinates::Metres,
    all_polygons: false,
    origin: None,
};

fn parse(text: &str) -> Result<GeoJsonCity, GeoJsonError> {
    parse_geojson(text, &GeoJsonConfig::default())
}

/// Checks that the error of a text has all of these words.
#[track_caller]
fn check_error(text: &str, expected: &[&str]) {
    check_error_with(text, &GeoJsonConfig::default(), expected);
}

#[track_caller]
fn check_error_with(text: impl AsRef<[u8]>, config: &GeoJsonConfig, expected: &[&str]) {
    let words = parse_geojson(text, config).unwrap_err().to_string();
    assert!(expected.iter().all(|e| words.contains(e)), "{words}");
}

fn feature(tags: &str, geometry: &str, coordinates: &str) -> String {
    format!(
        r#"{{"type":"Feature","properties":{{{tags}}},"geometry":{{"type":"{geometry}","coordinates":{coordinates}}}}}"#
    )
}

fn house(ring: &str) -> String {
    feature(YES, "Polygon", &format!("[{ring}]"))
}

/// The square with tags.
fn tagged(tags: &str) -> String {
    feature(tags, "Polygon", &format!("[{SQUARE}]"))
}

fn collection(features: &[String]) -> String {
    format!(
        r#"{{"type":"FeatureCollection","features":[{}]}}"#,
        features.join(",")
    )
}

/// Adds a reference system to a collection.
fn with_crs(collection: &str, name: &str) -> String {
    let member = format!(r#"{{"crs":{{"type":"name","properties":{{"name":"{name}"}}}},"#);
    collection.replacen('{', &member, 1)
}

/// A rectangle from a corner, as a ring.
fn rectangle([x, y]: [f64; 2], [w, h]: [f64; 2]) -> String {
    let (x1, y1) = (x + w, y + h);
    format!("[[{x},{y}],[{x1},{y}],[{x1},{y1}],[{x},{y1}],[{x},{y}]]")
}

/// Extent from west to east and from south to north.
fn extent(city: &GeoJsonCity) -> DVec2 {
    let points = city.footprints.iter().flat_map(|f| f.outer.iter().copied());
    let (min, max) = ring::bounds(points);
    max - min
}

#[track_caller]
fn check_extent(city: &GeoJsonCity, expected: DVec2) {
    let found = extent(city);
    assert!(found.distance(expected) < 2e-3, "{found}, not {expected}");
}

#[test]
fn only_buildings_with_walls_count() {
    let city = parse(&collection(&[
        tagged(r#""building":"yes""#),
        tagged(r#""building":"no""#),
        tagged(r#""building":"roof""#),
        tagged(r#""building":null"#),
        tagged(r#""building:part":"yes""#),
        tagged(r#""building":"garage","layer":"-1""#),
        tagged(r#""building":"yes","location":"underground""#),
        tagged(r#""building":"hotel","layer":1"#),
        feature(r#""building":"yes""#, "Point", "[24.945,60.168]"),
        feature(r#""highway":"residential""#, "LineString", SQUARE),
    ]))
    .unwrap();
    assert_eq!(city.footprints.len(), 2);
    let expected = Skipped {
        features: 7,
        without_area: 1,
        ..Skipped::default()
    };
    assert_eq!(city.skipped, expected);
}

#[test]
fn buildings_that_do_not_stand_are_passed_over_and_counted() {
    let city = parse(&collection(&[
        tagged(r#""building":"construction","construction":"apartments""#),
        tagged(r#""building":"ruins""#),
        tagged(r#""building":"house","ruins":"yes""#),
        tagged(r#""building":"collapsed""#),
        tagged(r#""building":"house","demolished":"yes""#),
        tagged(r#""building":"proposed""#),
        tagged(r#""building":"house","abandoned":"yes""#),
        tagged(r#""building":"house","ruins":"no","disused":"yes""#),
    ]))
    .unwrap();
    assert_eq!(city.footprints.len(), 2);
    assert_eq!((city.skipped.not_standing, city.skipped.features), (6, 0));
    let none = collection(&[tagged(r#""building":"construction""#)]);
    assert_eq!(parse(&none), Err(GeoJsonError::NoBuilding { features: 1 }));
}

#[test]
fn tags_may_lie_under_tags() {
    let with = |tags: &str| tagged(&format!(r#""id":7,"tags":{{{tags}}}"#));
    let city = parse(&collection(&[
        with(r#""building":"house""#),
        with(r#""landuse":"residential""#),
        with(r#""building":"garage","layer":"-1""#),
        tagged(r#""building":null,"tags":{"building":"yes"}"#),
        tagged(r#""tags":"building""#),
    ]))
    .unwrap();
    assert_eq!((city.footprints.len(), city.skipped.features), (2, 3));
}

#[test]
fn multipolygons_and_collections_are_taken_apart_and_holes_kept() {
    let yard = "[[24.9452,60.1681],[24.9458,60.1681],[24.9458,60.1684],[24.9452,60.1681]]";
    let multi = feature(
        YES,
        "MultiPolygon",
        &format!("[[{SQUARE},{yard}],[{SQUARE}]]"),
    );
    let inner = format!(r#"{{"type":"Polygon","coordinates":[{SQUARE}]}}"#);
    let nested = format!(
        r#"{{"type":"Feature","properties":{{"building":"yes"}},"geometry":{{"type":"GeometryCollection",
            "geometries":[{inner},{{"type":"GeometryCollection","geometries":[{inner}]}}]}}}}"#
    );
    let city = parse(&collection(&[multi, nested])).unwrap();
    let holes: Vec<usize> = city.footprints.iter().map(|f| f.holes.len()).collect();
    assert_eq!(holes, [1, 0, 0, 0]);
}

#[test]
fn rings_without_area_are_passed_over() {
    let flat = "[[24.945,60.168],[24.946,60.168],[24.945,60.168]]";
    let city = parse(&collection(&[
        house(flat),
        feature(YES, "Polygon", &format!("[{SQUARE},{flat},[]]")),
        feature(YES, "Polygon", "[]"),
    ]))
    .unwrap();
    assert_eq!((city.footprints.len(), city.skipped.rings), (1, 3));
    assert!(city.footprints[0].holes.is_empty());
}

#[test]
fn empty_members_do_not_spoil_those_beside_them() {
    let city = parse(&collection(&[
        feature(YES, "MultiPolygon", &format!("[[],[{SQUARE}]]")),
        feature(YES, "MultiPolygon", &format!("[[{SQUARE}],[[]]]")),
        feature(YES, "MultiPolygon", &format!("[[{SQUARE},[]]]")),
    ]))
    .unwrap();
    assert_eq!((city.footprints.len(), city.skipped.rings), (3, 3));
    let bare = |geometry: &str| {
        format!(r#"{{"type":"Feature","properties":{{{YES}}},"geometry":{geometry}}}"#)
    };
    let city = parse(&collection(&[
        house(SQUARE),
        feature(YES, "MultiPolygon", "[[]]"),
        feature(YES, "MultiPolygon", "[[],[]]"),
        feature(YES, "MultiPolygon", "[]"),
        feature(YES, "Polygon", "[[]]"),
        bare(r#"{"type":"GeometryCollection","geometries":[]}"#),
        bare("{}"),
        bare("null"),
        format!(r#"{{"type":"Feature","properties":{{{YES}}}}}"#),
    ]))
    .unwrap();
    assert_eq!((city.footprints.len(), city.skipped.without_area), (1, 8));
    assert_eq!(city.skipped.rings, 0);
}

#[test]
fn metres_are_asked_for_never_guessed() {
    let metric = house("[[385000.5,6671000],[385010,6671000],[385010,6671010]]");
    let city = parse_geojson(&metric, &METRES).unwrap();
    assert_eq!(city.footprints[0].outer[0].x + city.origin[0], 385_000.5);
    assert_eq!(city.crs, None);
    check_error(&metric, &["feature 0: (385000.5, 6671000)", "longitude"]);
    let small = house("[[0,0],[50,0],[50,30]]");
    assert!(matches!(parse(&small), Err(GeoJsonError::TooLarge { .. })));
    assert!(parse_geojson(&small, &METRES).is_ok());
}

#[test]
fn origin_that_is_asked_for_becomes_zero() {
    let at = |origin, coordinates| GeoJsonConfig {
        coordinates,
        origin: Some(origin),
        ..GeoJsonConfig::default()
    };
    let (metric, degrees) = (house("[[100.5,20],[110,20],[110,30]]"), house(SQUARE));
    let config = at([100.0, 0.0], Coordinates::Metres);
    let city = parse_geojson(&metric, &config).unwrap();
    assert_eq!(city.footprints[0].outer[0], DVec2::new(0.5, 20.0));
    assert_eq!(city.origin, [100.0, 0.0]);
    let config = at([24.945, 60.168], Coordinates::Degrees);
    let city = parse_geojson(&degrees, &config).unwrap();
    assert_eq!(city.footprints[0].outer[0], DVec2::ZERO);
    // The same houses, about another place of the plane.
    let own = parse(&degrees).unwrap();
    check_extent(&own, extent(&city));
    let no_degrees = [[0.0, 90.0], [361.0, 0.0], [f64::NAN, 0.0]];
    let no_metres = [[1e9, 0.0], [0.0, f64::NAN], [0.0, f64::INFINITY]];
    let refused = no_degrees.map(|origin| (&degrees, origin, Coordinates::Degrees));
    let of_metres = no_metres.map(|origin| (&metric, origin, Coordinates::Metres));
    for (text, origin, unit) in refused.into_iter().chain(of_metres) {
        let found = parse_geojson(text, &at(origin, unit));
        assert!(matches!(found, Err(GeoJsonError::Origin(_))), "{found:?}");
    }
    let far = parse_geojson(&degrees, &at([0.0, 0.0], Coordinates::Degrees));
    assert!(matches!(far, Err(GeoJsonError::TooLarge { .. })));
}

#[test]
fn web_mercator_is_the_same_city_in_true_metres() {
    let corner = [2_226_389.815_865, 8_399_737.889_818];
    let text = collection(&[house(&rectangle(corner, [39.899_458, 19.983_369]))]);
    let city = parse(&with_crs(&text, "urn:ogc:def:crs:EPSG::3857")).unwrap();
    // At 60 degrees north the map is twice as long as the ground.
    check_extent(&city, DVec2::new(20.0, 10.0));
    assert!(
        (city.origin[0] - 20.000_179).abs() < 1e-6 && (city.origin[1] - 60.000_045).abs() < 1e-6
    );
    assert_eq!(city.crs.as_deref(), Some("EPSG:3857"));
    let text = with_crs(&text, "EPSG:3857");
    let contradiction = parse_geojson(text, &METRES);
    assert!(matches!(contradiction, Err(GeoJsonError::NotMetres { .. })));
}

#[test]
fn utm_is_taken_back_to_the_ground_or_as_it_is() {
    // On the central meridian 1000 m of the grid are 1000.4 m of ground.
    let text = collection(&[house(&rectangle(
        [499_500.0, 6_651_000.0],
        [1000.0, 1000.0],
    ))]);
    let text = with_crs(&text, "urn:ogc:def:crs:EPSG::32633");
    let city = parse(&text).unwrap();
    check_extent(&city, DVec2::splat(1000.4));
    assert!((city.origin[0] - 15.0).abs() < 1e-4);
    let as_it_is = parse_geojson(&text, &METRES).unwrap();
    assert_eq!(extent(&as_it_is), DVec2::splat(1000.0));
    assert_eq!(as_it_is.crs.as_deref(), Some("EPSG:32633"));
}

#[test]
fn reference_systems_that_contradict_are_errors() {
    let here = collection(&[house(SQUARE)]);
    let feet = with_crs(&here, "urn:ogc:def:crs:EPSG::2263");
    for config in [GeoJsonConfig::default(), METRES] {
        check_error_with(&feet, &config, &["EPSG::2263", "ogr2ogr"]);
    }
    let degrees = with_crs(&here, "urn:ogc:def:crs:OGC:1.3:CRS84");
    assert_eq!(parse(&degrees), parse(&here));
    let contradiction = parse_geojson(&degrees, &METRES);
    assert!(matches!(contradiction, Err(GeoJsonError::NotMetres { .. })));
    let null = here.replacen('{', r#"{"crs":null,"#, 1);
    assert_eq!(parse(&null), Err(GeoJsonError::UnknownCrs));
    // Two collections in a row, of which one is elsewhere.
    let mixed = format!("{here}\n{}", with_crs(&here, "EPSG:3857"));
    check_error(&mixed, &["feature 1 is in EPSG:3857"]);
    // Degrees under the name of a map in metres are grains of sand off the African coast.
    for name in ["EPSG:3857", "EPSG:32633"] {
        check_error(&with_crs(&here, name), &["another unit"]);
    }
    let far = collection(&[house("[[2e6,1],[2e6,2],[3e6,3]]")]);
    check_error(
        &with_crs(&far, "EPSG:25832"),
        &["is no position of EPSG:25832"],
    );
}

#[test]
fn features_and_geometries_may_name_their_own_system() {
    let ring = rectangle([499_500.0, 6_651_000.0], [100.0, 100.0]);
    let crs = r#""crs":{"type":"name","properties":{"name":"EPSG:32633"}},"#;
    for at in [r#"{"type":"Polygon""#, r#"{"type":"Feature""#] {
        let text = house(&ring).replacen(at, &at.replacen('{', &format!("{{{crs}"), 1), 1);
        assert_eq!(parse(&text).unwrap().crs.as_deref(), Some("EPSG:32633"));
    }
}

#[test]
fn date_line_is_no_border() {
    let at = |west: f64| {
        collection(&[-0.001, 0.0005].map(|x| house(&rectangle([west + x, -16.8], [2e-4, 1e-4]))))
    };
    let far = extent(&parse(&at(20.0)).unwrap());
    let [a, b] = [179.999, -179.9995].map(|x| house(&rectangle([x, -16.8], [2e-4, 1e-4])));
    for text in [at(180.0), at(-180.0), collection(&[a, b])] {
        let city = parse(&text).unwrap();
        check_extent(&city, far);
        assert!(city.origin[0].abs() <= 180.0, "{:?}", city.origin);
    }
    // A house across it, in both ways of writing.
    let across = |east: f64| {
        house(&format!(
            "[[179.9999,5],[{east},5],[{east},5.0001],[179.9999,5]]"
        ))
    };
    for text in [across(180.0001), across(-179.9999)] {
        assert!((extent(&parse(&text).unwrap()).x - 22.18).abs() < 0.01);
    }
    // From 0 to 360 degrees about Greenwich.
    let zero = collection(&[
        house(&rectangle([359.9999, 51.0], [1e-4, 1e-4])),
        house(&rectangle([1e-4, 51.0], [1e-4, 1e-4])),
    ]);
    assert!(extent(&parse(&zero).unwrap()).x < 30.0);
}

#[test]
fn latitudes_beyond_the_poles_ask_whether_axes_are_swapped() {
    let tokyo = house("[[35.68,139.76],[35.68,139.77],[35.69,139.77]]");
    check_error(&tokyo, &["139.76 is no latitude", "swapped"]);
    let nowhere = house("[[200,100],[201,100],[201,101]]");
    check_error(&nowhere, &["is no longitude and latitude"]);
    check_error(&house("[[0,89.5],[1,89.5],[1,89.6]]"), &["pole"]);
}

#[test]
fn features_may_stand_in_a_row() {
    let one = house(SQUARE);
    let collections = collection(std::slice::from_ref(&one));
    for text in [
        format!("{one}\n{one}\n{one}\n"),
        format!("{one}{one}\r\n{one}"),
        format!("\u{1e}{one}\n\u{1e}{one}\n\u{1e}{one}\n"),
        format!("{collections}\n{collections}\n{collections}"),
        format!("\u{feff}{collections}{one}\n\n{one}"),
    ] {
        assert_eq!(parse(&text).unwrap().footprints.len(), 3, "{text}");
    }
    check_error(&format!("{one}\n{one}\n{{\"type\":"), &["line 3"]);
}

#[test]
fn drawings_in_other_units_are_not_empty_maps() {
    let kilometres = collection(&[house(&rectangle([0.1, 0.2], [0.02, 0.03]))]);
    let words = parse_geojson(kilometres, &METRES).unwrap_err().to_string();
    assert!(
        words.contains("0.029 m long") || words.contains("0.030 m long"),
        "{words}"
    );
}

#[test]
fn files_without_buildings_say_so() {
    let tree = collection(&[feature(r#""natural":"tree""#, "Point", "[24.9,60.1]")]);
    assert_eq!(parse(&tree), Err(GeoJsonError::NoTag { features: 1 }));
    assert_eq!(parse(&collection(&[])), Err(GeoJsonError::NoFeature));
    let none = tagged(r#""building":"no""#);
    assert_eq!(parse(&none), Err(GeoJsonError::NoBuilding { features: 1 }));
    let bare = format!(r#"{{"type":"Polygon","coordinates":[{SQUARE}]}}"#);
    assert_eq!(parse(&bare), Err(GeoJsonError::NoTag { features: 1 }));
    let config = GeoJsonConfig {
        all_polygons: true,
        ..GeoJsonConfig::default()
    };
    assert_eq!(parse_geojson(&bare, &config).unwrap().footprints.len(), 1);
    let short = feature(YES, "Polygon", "[[[1,2],[1]]]");
    assert_eq!(parse(&short), Err(GeoJsonError::Position { feature: 0 }));
}

#[test]
fn what_is_no_geojson_is_named() {
    for (text, expected) in [
        ("", "the file is empty"),
        ("[]", "`type`"),
        ("{}", "`type`"),
        (
            r#"{"type":"Topology","objects":{}}"#,
            "a Topology is no object",
        ),
        (r#"{"type":"FeatureCollection"}"#, "without `features`"),
        (
            r#"{"type":"FeatureCollection","features":[{}]}"#,
            "feature 0",
        ),
        (&house("7"), "feature 0: expected a list"),
        (
            r#"{"type":"Feature","properties":{"building":"yes","height":NaN}}"#,
            "NaN at line 1",
        ),
    ] {
        check_error(text, &[expected]);
    }
    let utf16: Vec<u8> = "{}".encode_utf16().flat_map(u16::to_le_bytes).collect();
    check_error_with(utf16, &GeoJsonConfig::default(), &["UTF-16"]);
}
