//! The reader of path lists fed with texts: valid ones with bytes changed, valid ones with values changed,
//! and JSON of any kind. What it accepts is labelled, and no label holds anything but finite numbers.

use aps_label::{LabelConfig, Labeler, PathSample};
use proptest::prelude::*;
use proptest::sample::{Index, select};
use serde_json::Value;

use super::{LinkList, PathEntry};

const VALID: &str = r#"{"links": [
    {"tx": [10.0, 20.5], "rx": [30, 40], "paths": [
        {"interactions": [{"kind": "reflection", "wall": 3, "point": [1.5, 2.0]}], "length_m": 30.5,
         "delay_s": 1.5e-7, "departure_azimuth_rad": 0.5, "arrival_azimuth_rad": -2.25, "gain_db": -80.5},
        {"delay_s": 2e-7, "arrival_azimuth_rad": 1, "gain_db": -101}]},
    {"paths": [{"delay_s": 0.0, "arrival_azimuth_rad": 3.14, "gain_db": -60.0,
        "interactions": [{"kind": "diffraction", "corner": 7, "point": [0, 0]}]}]}]}"#;

thread_local! {
    static LABELER: Labeler = Labeler::new(&LabelConfig::released()).unwrap();
}

/// Whatever the bytes, reading and labelling return; a label is finite.
fn read_and_label(bytes: &[u8]) {
    let Ok(list) = LinkList::read(bytes) else {
        return;
    };
    assert!(list.links.len() <= bytes.len());
    for link in &list.links {
        let paths: Result<Vec<PathSample>, _> = link.paths.iter().map(PathEntry::sample).collect();
        let Ok(paths) = paths else {
            continue;
        };
        if let Ok(Some(label)) = LABELER.with(|labeler| labeler.label(&paths)) {
            assert!(label.aps_db.iter().all(|db| db.is_finite()), "{paths:?}");
        }
    }
}

#[test]
fn the_sample_is_valid() {
    let list: LinkList = serde_json::from_str(VALID).unwrap();
    assert_eq!(list.links[0].paths.len(), 2);
    read_and_label(VALID.as_bytes());
}

fn any_json() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Into::into),
        any::<u64>().prop_map(Into::into),
        any::<f64>().prop_map(Into::into),
        select(vec![0.0, -0.0, 1e-320, 1e308, -1e308, 5.0, -310.0]).prop_map(Into::into),
        "(reflection|diffraction|[a-z]{0,3})".prop_map(Into::into),
    ];
    leaf.prop_recursive(4, 16, 4, |inner| {
        let keys = "(links|paths|delay_s|arrival_azimuth_rad|gain_db|interactions|kind|[a-z]{1,2})";
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Into::into),
            prop::collection::btree_map(keys, inner, 0..5)
                .prop_map(|map| Value::Object(map.into_iter().collect())),
        ]
    })
}

/// A path whose needed numbers are of any size.
fn any_path() -> impl Strategy<Value = Value> {
    let number = prop_oneof![any::<f64>(), -1e3..1e3, 0.0..1e-6];
    [number.clone(), number.clone(), number].prop_map(|[delay, azimuth, gain]| {
        serde_json::json!({ "delay_s": delay, "arrival_azimuth_rad": azimuth, "gain_db": gain })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(1_000)))]

    #[test]
    fn list_with_bytes_changed(
        changes in prop::collection::vec((any::<Index>(), select(b"0123456789-e.\"{}[],: \\xff".to_vec())), 1..4),
        cut in prop::option::weighted(0.1, any::<Index>()),
    ) {
        let mut bytes = VALID.as_bytes().to_vec();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        read_and_label(&bytes[..cut.map_or(bytes.len(), |cut| cut.index(bytes.len()))]);
    }

    #[test]
    fn paths_of_any_size(paths in prop::collection::vec(any_path(), 0..5)) {
        read_and_label(serde_json::json!({ "links": [{ "paths": paths }] }).to_string().as_bytes());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(1_000)))]

    #[test]
    fn list_of_any_json(value in any_json()) {
        read_and_label(value.to_string().as_bytes());
        read_and_label(serde_json::json!({ "links": [{ "paths": [value] }] }).to_string().as_bytes());
    }
}
