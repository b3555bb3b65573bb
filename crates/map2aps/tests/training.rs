//! Trainings by the library: cancelled and continued, and what they refuse.
#![cfg(feature = "models")]

#[path = "../src/synthetic.rs"]
mod synthetic;

use std::fs;
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use map2aps::aps_metrics::{Better, Metric};
use map2aps::aps_model::train::StepReport;
use map2aps::aps_model::{ANGLE_BINS, ModelKind, Preset};
use map2aps::training::*;
use map2aps::*;

/// Cancels the training after some steps.
struct Stop {
    cancel: AtomicBool,
    steps: AtomicU64,
}

impl Progress for Stop {
    fn step(&self, _: &StepReport) {
        if self.steps.fetch_sub(1, Ordering::Relaxed) == 1 {
            self.cancel.store(true, Ordering::Relaxed);
        }
    }
}

fn dataset(folder: &Path) -> Dataset {
    synthetic::made(&synthetic::plan(3, 1, 12), folder, &[0, 1, 2])
}

fn training() -> Training {
    let mut training = Training {
        image_size: 32,
        ..Training::new(ModelKind::ResnetMlp, Preset::Small)
    };
    training.config.epochs = 2;
    training.config.batch = 4;
    training
}

/// A data set and the folder of a finished run on it, both in the folder that is returned.
fn trained() -> (tempfile::TempDir, Dataset, PathBuf) {
    let root = tempfile::tempdir().unwrap();
    let run = root.path().join("run");
    let dataset = dataset(&root.path().join("data"));
    training().run(&dataset, &run, &Control::default()).unwrap();
    (root, dataset, run)
}

fn continues_to_the_same_bytes(training: Training) {
    let root = tempfile::tempdir().unwrap();
    let [data, whole, parts] = ["data", "whole", "parts"].map(|name| root.path().join(name));
    let dataset = dataset(&data);
    let trained = training.run(&dataset, &whole, &Control::default()).unwrap();
    let stop = Stop {
        cancel: AtomicBool::new(false),
        steps: AtomicU64::new(2),
    };
    let control = Control {
        progress: &stop,
        cancel: &stop.cancel,
        ..Control::default()
    };
    let cancelled = training.run(&dataset, &parts, &control).unwrap_err();
    assert!(cancelled.is_cancelled(), "{}", cancelled.chain());
    let told = cancelled.chain();
    assert!(told.starts_with("interrupted after 2 of "), "{told}");
    // Another run in the same folder is none, and leaves no trace.
    let settings = fs::read(parts.join("config.json")).unwrap();
    let other = Training {
        development_links: Some(2),
        ..training.clone()
    };
    let refused = other.run(&dataset, &parts, &Control::default());
    let refused = refused.unwrap_err();
    let is_told = refused.chain().contains("dev_links is ");
    assert!(is_told, "{}", refused.chain());
    assert!(fs::read(parts.join("config.json")).unwrap() == settings);
    training.run(&dataset, &parts, &Control::default()).unwrap();
    // Weights whose checkpoint is gone are not replaced by those of a new run.
    let (checkpoint, aside) = (parts.join("last.safetensors"), root.path().join("aside"));
    fs::rename(&checkpoint, &aside).unwrap();
    let refused = training.run(&dataset, &parts, &Control::default());
    let told = refused.unwrap_err().chain();
    assert!(
        told.contains("best.safetensors' would be replaced"),
        "{told}"
    );
    fs::rename(&aside, &checkpoint).unwrap();
    // Nor does a run go on whose best weights are gone.
    let best = parts.join("best.safetensors");
    fs::rename(&best, &aside).unwrap();
    let refused = training.run(&dataset, &parts, &Control::default());
    let told = refused.unwrap_err().chain();
    assert!(told.contains("has its best weights in"), "{told}");
    fs::rename(&aside, &best).unwrap();
    for name in [
        "steps.csv",
        "scores.csv",
        "config.json",
        "best.safetensors",
        "last.safetensors",
    ] {
        let read = |folder: &Path| fs::read(folder.join(name)).unwrap();
        assert!(read(&whole) == read(&parts), "{name}");
    }

    let test = Examples::load(&dataset, Part::Test, Domain::Normalised).unwrap();
    let predicted = trained.predict(&test).unwrap();
    assert_eq!(predicted.len(), test.list().len() * ANGLE_BINS);
    let again = Trained::load(
        &parts.join("best.safetensors"),
        None,
        None,
        &Device::Cpu.open().unwrap(),
    );
    let again = again.unwrap();
    assert!(again.predict(&test).unwrap() == predicted);
    // Images are no geometry, and released targets tell no power.
    let kind = again.label().kind;
    let refused = LinkModel::new(again).unwrap_err();
    let is_told = match refused.cause() {
        Error::Training(TrainingError::NoGeometry(_)) => kind == ModelKind::ResnetMlp,
        Error::Training(TrainingError::NoPower(_)) => kind == ModelKind::PolarReg,
        _ => false,
    };
    assert!(is_told, "{kind}: {}", refused.chain());
}

#[test]
fn a_cancelled_training_continues_to_the_same_bytes() {
    continues_to_the_same_bytes(training());
}

/// Fields of the scenes, mirrored, in an order in which transmitters' links are together.
#[test]
fn a_cancelled_training_on_fields_continues_to_the_same_bytes() {
    let mut training = Training {
        mirror: true,
        ..Training::new(ModelKind::PolarReg, Preset::Small)
    };
    training.config.epochs = 1;
    training.config.batch = 12;
    continues_to_the_same_bytes(training);
}

/// The step whose row in `scores.csv` is best in a metric, the first of equals.
fn best_row(scores: &str, metric: Metric) -> u64 {
    let mut rows = scores.lines().map(|row| row.split(',').collect::<Vec<_>>());
    let names = rows.next().unwrap();
    let name = format!("dev_{}", metric.key());
    let column = names.iter().position(|of| *of == name).unwrap();
    let sign = match metric.better() {
        Better::Lower => 1.0,
        Better::Higher => -1.0,
    };
    let cost = |row: &Vec<&str>| sign * row[column].parse::<f64>().unwrap();
    let best = rows.min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap();
    best[0].parse().unwrap()
}

#[test]
fn the_best_weights_are_those_of_the_metric_that_is_asked_for() {
    let root = tempfile::tempdir().unwrap();
    let dataset = dataset(&root.path().join("data"));
    // The training itself is the same whatever it is judged by.
    let trained = |name: &str, selection: Selection| {
        let mut training = Training {
            selection,
            score_every: NonZeroU64::new(1),
            ..training()
        };
        training.config.epochs = 3;
        training.config.learning_rate = 1e-3;
        let folder = RunFolder::create(&root.path().join(name)).unwrap();
        let mut run = training.prepare(&dataset, folder.clone(), false).unwrap();
        run.train(&Control::default()).unwrap();
        let chosen_by = run.settings().chosen_by.clone();
        let scores = fs::read_to_string(folder.scores()).unwrap();
        (run.best_steps().unwrap(), chosen_by.unwrap(), scores)
    };
    let (by_loss, chosen_by, scores) = trained("loss", Selection::Loss);
    assert_eq!(
        (by_loss, &*chosen_by),
        (best_row(&scores, Metric::Mse), "mse")
    );
    for better in [Better::Lower, Better::Higher] {
        // One that is best after other steps.
        let others = Metric::ALL.into_iter().filter(|m| m.better() == better);
        let metric = others.rev().find(|&m| best_row(&scores, m) != by_loss);
        let metric = metric.unwrap_or_else(|| panic!("{better:?}: {scores}"));
        let (steps, chosen_by, again) = trained(metric.key(), Selection::Metric(metric));
        assert_eq!(
            (steps, &*chosen_by),
            (best_row(&scores, metric), metric.key())
        );
        assert_eq!(again, scores);
    }
}

#[test]
fn labels_of_another_kind_are_not_learnt_by_the_same_run() {
    let (_root, dataset, run) = trained();
    let manifest = dataset.root().join("manifest.json");
    let text = fs::read_to_string(&manifest).unwrap();
    let settings = &dataset.manifest().configuration;
    let frequency = settings["trace"]["frequency_hz"].to_string();
    assert_eq!(text.matches(&frequency).count(), 1, "{frequency}");
    fs::write(&manifest, text.replace(&frequency, "28000000000.0")).unwrap();
    let folder = RunFolder::create(&run).unwrap();
    let other = Dataset::open(dataset.root()).unwrap();
    let refused = training().prepare(&other, folder, true).unwrap_err();
    let told = refused.chain();
    for part in [
        "config.json",
        "data_configuration.trace.frequency_hz",
        "28000000000",
    ] {
        assert!(told.contains(part), "{told}");
    }
}

#[test]
fn two_runs_do_not_write_into_one_folder() {
    let root = tempfile::tempdir().unwrap();
    let [data, run] = ["data", "run"].map(|name| root.path().join(name));
    let dataset = dataset(&data);
    let folder = RunFolder::create(&run).unwrap();
    let first = training().prepare(&dataset, folder.clone(), false).unwrap();
    let second = training().prepare(&dataset, folder.clone(), false);
    let refused = second.unwrap_err();
    let is_told = matches!(refused.cause(), Error::Data(aps_data::Error::Locked { .. }));
    assert!(is_told, "{}", refused.chain());
    drop(first);
    training().prepare(&dataset, folder, false).unwrap();
}

#[test]
fn weights_beside_settings_of_another_model_are_refused() {
    let (_root, _, run) = trained();
    let settings = run.join("config.json");
    let text = fs::read_to_string(&settings).unwrap();
    fs::write(&settings, text.replace("resnet_mlp", "radiounet")).unwrap();
    let weights = run.join("best.safetensors");
    let refused = Trained::load(&weights, None, None, &Device::Cpu.open().unwrap());
    let told = refused.unwrap_err().chain();
    assert!(
        told.contains("config.json") && told.contains("radiounet"),
        "{told}"
    );
}

/// `map2aps.torch.models.save` writes these beside its weights.
#[test]
fn settings_of_another_program_need_what_predictions_do() {
    let (_root, dataset, run) = trained();
    let settings = run.join("config.json");
    let text = fs::read_to_string(&settings).unwrap();
    let mut all: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&text).unwrap();
    let needed = [
        "model",
        "preset",
        "image_size",
        "sigma_px",
        "data",
        "data_configuration",
        "protocol",
        "training_statistics",
    ];
    let load = || {
        let device = Device::Cpu.open().unwrap();
        Trained::load(&run.join("best.safetensors"), None, None, &device)
    };
    let size = load().unwrap().images().image_size;
    all.retain(|name, _| needed.contains(&name.as_str()));
    fs::write(&settings, serde_json::to_string(&all).unwrap()).unwrap();
    let known = load().unwrap();
    assert_eq!(known.images().image_size, size);
    assert!(known.assumed_image_size().is_none());
    assert!(known.differences(&dataset).unwrap().is_empty());
    for name in needed {
        let mut less = all.clone();
        less.remove(name);
        fs::write(&settings, serde_json::to_string(&less).unwrap()).unwrap();
        let told = load().unwrap_err().chain();
        assert!(told.contains(name), "{told}");
    }
    fs::remove_file(&settings).unwrap();
    assert!(load().unwrap().assumed_image_size().is_some());
}

#[test]
fn what_cannot_be_trained_is_told() {
    let root = tempfile::tempdir().unwrap();
    let (data, run) = (root.path().join("data"), root.path().join("run"));
    let dataset = dataset(&data);
    let refused = |training: Training| {
        let refused = training.run(&dataset, &run, &Control::default());
        refused.unwrap_err()
    };
    let error = refused(Training {
        development_maps: DevelopmentMaps::Ids(vec![2]),
        ..training()
    });
    let cause = error.cause();
    assert!(
        matches!(cause, Error::Training(TrainingError::NotATrainingMap { id: 2, pool }) if *pool == [0, 1]),
        "{cause:?}"
    );
    let mut hurried = training();
    hurried.config.budget_s = Some(1e-9);
    let error = refused(hurried);
    assert!(
        matches!(error.cause(), Error::Training(TrainingError::NoStep(s)) if *s > 0.0),
        "{}",
        error.chain()
    );
    // The folder can be begun anew, and there is nothing to continue.
    let folder = RunFolder::create(&run).unwrap();
    let error = training().prepare(&dataset, folder, true).unwrap_err();
    assert!(matches!(
        error.cause(),
        Error::Training(TrainingError::NoRun(_))
    ));
}
