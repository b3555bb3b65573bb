//! Weights that come with `aps-model`, on a small data set of another city.
#![cfg(all(feature = "models", feature = "geojson"))]

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use map2aps::aps_model::weights::Shipped;
use map2aps::aps_model::{ANGLE_BINS, ModelKind};
use map2aps::maps::TileSettings;
use map2aps::targets::learning_target;
use map2aps::training::{self, Device, Trained};
use map2aps::{Domain, Examples, MapSource, Metric, Part, Prediction, Scoring, Truth};

fn data(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data")).join(name)
}

/// Mean scores of a model's shipped weights on the test map.
fn scores(kind: ModelKind) -> BTreeMap<String, f64> {
    let folder = data("shipped");
    let dataset = training::open(&folder).unwrap();
    let (.., target) = learning_target(&dataset).unwrap();
    let maps = MapSource::geojson(data("helsinki.geojson"), TileSettings::default()).unwrap();
    let trained = Trained::shipped(kind, &Device::Cpu.open().unwrap())
        .unwrap()
        .with_maps(Some(maps))
        .for_targets(target);
    let test = Examples::load(&dataset, Part::Test, Domain::Normalised).unwrap();
    let (values, bins) = (&trained.predict(&test).unwrap(), ANGLE_BINS);
    let mut truth = Truth::dataset(&folder, Part::Test, Domain::Normalised).unwrap();
    let scored = Scoring::default().score(&mut truth, Prediction::Values { values, bins });
    let overall = scored.unwrap().report.overall;
    let mean = |metric: Metric| Some((metric.key().to_owned(), overall.get(metric)?.mean));
    Metric::PAPER_COLUMNS.into_iter().filter_map(mean).collect()
}

#[test]
fn shipped_weights_reproduce_their_scores() {
    let text = fs::read_to_string(data("shipped.json")).unwrap();
    let stated: BTreeMap<String, BTreeMap<String, f64>> = serde_json::from_str(&text).unwrap();
    for shipped in Shipped::all() {
        let kind = shipped.label.kind;
        let found = scores(kind);
        let now = || serde_json::to_string(&found).unwrap();
        let stated = stated.get(kind.name());
        let stated = stated.unwrap_or_else(|| panic!("{kind} has no scores stated: {}", now()));
        assert_eq!(stated.len(), found.len());
        for (metric, value) in &found {
            let difference = value - stated[metric];
            // Relative where a score is in degrees or dB.
            let scale = value.abs().max(1.0);
            assert!(
                difference.abs() <= 1e-3 * scale,
                "{kind} {metric}: {found:?}, stated is {stated:?}"
            );
        }
    }
}

#[test]
fn a_model_without_shipped_weights_is_told_which_have_some() {
    let device = Device::Cpu.open().unwrap();
    let refused = Trained::shipped(ModelKind::VitReg, &device).unwrap_err();
    let told = refused.to_string();
    assert!(told.contains("polar_reg"), "{told}");
}

#[test]
fn shipped_weights_take_little_room_and_have_their_card() {
    let bytes: usize = Shipped::all().map(|shipped| shipped.bytes.len()).sum();
    assert!(bytes <= 12 << 20, "{bytes}");
    for shipped in Shipped::all() {
        for word in ["Data", "Settings", "Scores", "Not good for"] {
            assert!(shipped.card.contains(&format!("## {word}")), "{word}");
        }
        assert!(shipped.card.contains(shipped.label.kind.title()));
    }
}
