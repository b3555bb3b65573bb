//! The reader of RadioMapSeer footprints fed with any bytes, any JSON, and valid maps with bytes or numbers changed. What it accepts becomes a scene, and a link across it is traced: errors are typed, nothing panics,
//! and every number that comes out is finite.

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Area, Footprint, parse_radiomapseer};
use aps_raytrace::{Scene, TraceConfig, Tracer};
use aps_tests::links::{assert_finite, with_chains};
use proptest::prelude::*;
use proptest::sample::{Index, select};

const VALID: &str = "[[[40, 60], [70, 60], [70, 80], [40, 80], [40, 60]], \
    [[90, 30], [105, 30], [105.5, 90], [97, 60.25], [90, 90], [90, 30]], \
    [[60, 120], [110, 120], [110, 132], [60, 132], [60, 120]], [[105, 30], [120, 30], [120, 60]]]";

/// Reads; what is accepted is no larger than the text.
fn read(text: &str) -> Option<Vec<Footprint>> {
    let footprints = parse_radiomapseer(text).ok()?;
    let vertices: usize = footprints.iter().map(|f| f.outer.len()).sum();
    assert!(footprints.len() + vertices <= text.len());
    Some(footprints)
}

/// Reads and traces. Returns true when a link was traced.
fn trace(text: &str) -> bool {
    let Some(footprints) = read(text) else {
        return false;
    };
    let Ok(scene) = Scene::new(&footprints, Some(Area::RADIOMAPSEER)) else {
        return false;
    };
    assert!(
        scene
            .walls()
            .iter()
            .all(|w| w.a.is_finite() && w.b.is_finite())
    );
    let config = TraceConfig {
        max_reflections: 1,
        ..with_chains()
    };
    let Ok(tracer) = Tracer::new(&scene, config) else {
        return false;
    };
    let Ok(link) = tracer.trace(DVec2::new(80.0, 50.0), DVec2::new(50.0, 100.0)) else {
        return false;
    };
    assert_finite(&link, text);
    true
}

#[test]
fn the_sample_is_valid() {
    assert_eq!(read(VALID).unwrap().len(), 4);
    assert!(trace(VALID));
}

#[test]
fn nested_brackets_exhaust_nothing() {
    assert!(parse_radiomapseer("[".repeat(1_000_000)).is_err());
}

fn any_text() -> impl Strategy<Value = String> {
    prop_oneof![
        "[\\[\\],0-9eE.+\\- ]{0,60}",
        "[\\[\\]{}\":,0-9a-z\\\\ ]{0,60}",
        prop::collection::vec(any::<u8>(), 0..60)
            .prop_map(|bytes| String::from_utf8_lossy(&bytes).into_owned()),
    ]
}

/// Numbers that JSON can hold, of use and of none.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => (0..257_u32).prop_map(f64::from),
        2 => 0.0..256.0,
        1 => select(vec![-0.0, 1e9, -1e9, 1.1e9, 1e300, 1e-300, 1e-9, 255.999_999_999]),
        1 => any::<f64>().prop_filter("JSON has finite numbers only", |x| x.is_finite()),
    ]
}

/// Polygons of any shape: open and closed, crossing themselves, of no area, on top of each other.
fn any_map() -> impl Strategy<Value = String> {
    let vertex = [any_number(), any_number()];
    let polygon = prop::collection::vec(vertex, 0..7);
    prop::collection::vec(polygon, 0..5).prop_map(|map| format!("{map:?}"))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(1_000)))]

    #[test]
    fn any_bytes(text in any_text()) {
        read(&text);
        read(&format!("[[{text}]]"));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(1_000)))]

    #[test]
    fn valid_map_with_bytes_changed(
        changes in prop::collection::vec((any::<Index>(), select(b"0123456789-e.[], \"".to_vec())), 1..4),
        cut in prop::option::weighted(0.1, any::<Index>()),
    ) {
        let mut bytes = VALID.as_bytes().to_vec();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        let end = cut.map_or(bytes.len(), |cut| cut.index(bytes.len()));
        trace(std::str::from_utf8(&bytes[..end]).unwrap());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(1_000)))]

    #[test]
    fn polygons_of_any_shape(text in any_map()) {
        trace(&text);
    }
}
