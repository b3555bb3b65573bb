//! Weights that come with `aps-model`, on a small data set of another city.
#![cfg(all(feature = "models", feature = "geojson"))]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use map2aps::aps_label::Protocol;
use map2aps::aps_model::weights::Shipped;
use map2aps::aps_model::{ANGLE_BINS, ModelKind};
use map2aps::aps_raytrace::polar::Mirror;
use map2aps::maps::TileSettings;
use map2aps::targets::{self, learning_target};
use map2aps::training::{self, Device, LinkModel, Trained};
use map2aps::{
    Domain, Examples, Limits, MapSource, Metric, Part, PolarViews, Prediction, Scoring, SeenLink,
    Truth, settings,
};

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

/// The Python package has a list of its own, held to the same folder by its tests.
#[test]
fn everything_in_the_folder_of_shipped_weights_is_listed() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../aps-model/shipped");
    let names = fs::read_dir(folder).unwrap();
    let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let listed = Shipped::all().map(|shipped| shipped.label.kind.name().to_owned());
    assert_eq!(names.collect::<BTreeSet<_>>(), listed.collect());
}

/// Without the data set, from the scene alone: the same spectra but for the rounding of batches of other sizes, and the scores
/// that a label in dB gives.
#[test]
fn single_links_are_predicted_as_those_of_a_data_set() {
    let dataset = training::open(&data("shipped")).unwrap();
    let maps = MapSource::geojson(data("helsinki.geojson"), TileSettings::default()).unwrap();
    let trained = || {
        let device = Device::Cpu.open().unwrap();
        Trained::shipped(ModelKind::PolarReg, &device).unwrap()
    };
    let test = Examples::load(&dataset, Part::Test, Domain::Normalised).unwrap();
    let of_dataset = trained().with_maps(Some(maps.clone())).predict(&test);
    let of_dataset = of_dataset.unwrap();
    let id = test.list()[0].map;
    let configuration = &dataset.manifest().configuration;
    let settings = settings::scene_of(configuration).unwrap();
    let scene = maps.load(id, 0, settings).unwrap();
    let views = PolarViews::new([Ok((id, scene))].into_iter()).unwrap();
    let links: Vec<SeenLink> = test
        .list()
        .iter()
        .filter(|example| example.map == id)
        .map(|example| SeenLink {
            map: 0,
            tx_m: example.tx_m,
            rx_m: example.rx_m,
            mirror: Mirror::default(),
        })
        .collect();
    let deviation = trained().settings().unwrap().training_statistics.std;
    let model = LinkModel::new(trained()).unwrap();
    assert_eq!(model.label().protocol, Protocol::Paper);
    assert_eq!(*model.trace(), Limits::default().config());
    let rows = dataset.map(id).unwrap();
    for (row, link) in links.iter().enumerate().take(40) {
        let predicted = &model.predict(&views, &[*link]).unwrap()[0];
        let expected = &of_dataset[row * ANGLE_BINS..][..ANGLE_BINS];
        for (found, expected) in predicted.normalised.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-4,
                "link {row}: {found}, {expected}"
            );
        }
        let mut label = [0.0_f32; ANGLE_BINS];
        targets::spectra(&rows).read_relative_db(test.list()[row].link, &mut label);
        let label = label.map(f64::from);
        let scores = predicted.score(&label).unwrap();
        // The share of power is the target less its scale: errors shrink by the deviation.
        let power = label.map(|db| 10_f64.powf(db / 10.0));
        let errors = predicted.relative_power().zip(power);
        let mae = errors
            .map(|(found, truth)| (found - truth).abs())
            .sum::<f64>()
            / 180.0;
        assert!((scores.mae - mae / deviation).abs() < 1e-4, "link {row}");
        assert!(scores.cosine > -1.0 && scores.cosine <= 1.0);
    }
    let indoors = SeenLink {
        rx_m: [f64::NAN; 2],
        ..links[0]
    };
    assert!(model.predict(&views, &[indoors]).is_err());
    assert!(model.predict(&views, &[]).unwrap().is_empty());
}
