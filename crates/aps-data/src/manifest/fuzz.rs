//! The readers of `manifest.json`, `map.json` and `plan.json` fed with texts: valid ones with bytes
//! changed, valid ones with values changed, and JSON of any kind.

use std::path::Path;

use proptest::prelude::*;
use proptest::sample::{Index, select};
use serde_json::Value;

use super::*;
use crate::layout::{Precision, ProfileLayout};
use crate::plan::Plan;
use aps_label::Axis;

/// A valid manifest and a valid `map.json` of it.
fn samples() -> (Vec<u8>, Vec<u8>) {
    let axis = |stop, count| Axis {
        start: 0.0,
        stop,
        count,
        endpoint: true,
    };
    let layout = Layout {
        aps: Some(ProfileLayout::over(axis(180.0, 5))),
        pdp: Some(ProfileLayout {
            axis: axis(1000.0, 9),
            dtype: Precision::F32,
            argmax: true,
        }),
        paths: true,
        ..Layout::default()
    };
    let config = DatasetConfig {
        seed: 1,
        layout,
        configuration: serde_json::json!({ "label": { "protocol": "paper" } }),
    };
    let map = |id| {
        let mut entry = MapEntry {
            id,
            tx: 2,
            rx: 3,
            links: 6,
            paths: 4,
            interactions: 5,
            status: [("valid".into(), 4), ("no_path".into(), 2)].into(),
            statistics: Value::Null,
            files: Vec::new(),
        };
        let arrays = arrays_of(&layout, &entry.counts()).unwrap();
        let files = arrays.iter().map(|array| FileEntry {
            name: format!("{}.npy", array.name),
            dtype: array.dtype.into(),
            shape: array.shape.clone(),
            bytes: array.file_bytes().unwrap(),
            sha256: "0".repeat(64),
        });
        entry.files = files.collect();
        entry
    };
    let of_map = json::to_bytes(&MapManifest::new(config.clone(), map(3)));
    let maps = vec![map(3), map(46)];
    let manifest = Manifest::new(config, Split::of_maps([3, 46], 0), maps);
    (json::to_bytes(&manifest), of_map)
}

/// Checks that every reader returns on a text, and that a result it accepts agrees with itself.
fn read_all(bytes: &[u8]) {
    let path = Path::new("any.json");
    if let Ok(manifest) = Manifest::parse(path, bytes) {
        assert_eq!(manifest.problem(), None);
        // The bound that readers allocate by.
        for file in manifest.maps.iter().flat_map(|map| &map.files) {
            let elements: usize = file.shape.iter().product();
            assert!(elements as u64 <= file.bytes, "{file:?}");
        }
    }
    if let Ok(map) = MapManifest::parse(3, path, bytes) {
        assert_eq!(map.problem(3), None);
    }
    if let Ok(plan) = Plan::parse(path, bytes) {
        assert!(plan.maps.len() <= bytes.len());
    }
}

thread_local! {
    static SAMPLES: [Vec<u8>; 3] = {
        let (manifest, of_map) = samples();
        let plan = br#"{"format": "aps-dataset", "format_version": 1, "maps": [0, 7], "shards": 2, "command": ["a"]}"#;
        [manifest, of_map, plan.to_vec()]
    };
}

#[test]
fn samples_are_valid() {
    let path = Path::new("sample.json");
    SAMPLES.with(|[manifest, of_map, plan]| {
        assert!(Manifest::parse(path, manifest).is_ok());
        assert!(MapManifest::parse(3, path, of_map).is_ok());
        assert!(MapManifest::parse(4, path, of_map).is_err(), "another map");
        assert!(Plan::parse(path, plan).is_ok());
    });
}

#[test]
fn nested_brackets_exhaust_nothing() {
    read_all(&b"[".repeat(1_000_000));
}

/// Puts `value` in place of the value number `at` of a JSON tree, counted from the leaves.
fn replace(tree: &mut Value, at: &mut usize, value: &Value) -> bool {
    let children: Vec<&mut Value> = match tree {
        Value::Array(list) => list.iter_mut().collect(),
        Value::Object(object) => object.values_mut().collect(),
        _ => Vec::new(),
    };
    for child in children {
        if replace(child, at, value) {
            return true;
        }
    }
    if *at == 0 {
        *tree = value.clone();
        return true;
    }
    *at -= 1;
    false
}

fn any_json() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Into::into),
        any::<u64>().prop_map(Into::into),
        select(vec![0_u64, 1, 2, 6, 1 << 32, 1 << 53, u64::MAX]).prop_map(Into::into),
        select(vec![-1.5, 1e300, 0.1]).prop_map(Into::into),
        "[a-z_<|.0-9]{0,8}".prop_map(Into::into),
    ];
    leaf.prop_recursive(3, 12, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Into::into),
            prop::collection::btree_map("(id|tx|links|files|shape|maps|[a-z]{1,3})", inner, 0..4)
                .prop_map(|map| Value::Object(map.into_iter().collect())),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(1_000)))]

    #[test]
    fn valid_json_with_bytes_changed(
        which in 0..3_usize,
        changes in prop::collection::vec((any::<Index>(), select(b"0123456789-e.\"{}[],:ntf \xff".to_vec())), 1..4),
        cut in prop::option::weighted(0.1, any::<Index>()),
    ) {
        let mut bytes = SAMPLES.with(|samples| samples[which].clone());
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        read_all(&bytes[..cut.map_or(bytes.len(), |cut| cut.index(bytes.len()))]);
    }

    #[test]
    fn valid_json_with_a_value_changed(which in 0..3_usize, at in 0..220_usize, value in any_json()) {
        let bytes = SAMPLES.with(|samples| samples[which].clone());
        let mut tree: Value = serde_json::from_slice(&bytes).unwrap();
        replace(&mut tree, &mut { at }, &value);
        read_all(tree.to_string().as_bytes());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(1_000)))]

    #[test]
    fn any_json_with_our_name_on_it(value in any_json()) {
        let text = serde_json::json!({ "format": FORMAT, "format_version": FORMAT_VERSION, "maps": value });
        read_all(text.to_string().as_bytes());
        read_all(value.to_string().as_bytes());
    }
}
