//! The models: trained, then asked for the test links.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use aps_data::Dataset;
use aps_metrics::Metric;
use aps_model::candle_core;
use aps_model::train::predict;
use aps_model::weights::Label;
use aps_model::{ANGLE_BINS, ModelKind, Preset};
use aps_report::benchmark::{CurvePoint, EntryKind, Training};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::answer::Answer;
use super::config::{Config, LatencyConfig};
use super::latency;
use super::stamp::{Part, State, read_json, write_json};
use super::test_set::TestSet;
use crate::data::Buildings;
use crate::network::{self, InitialWeights};
use crate::run::TrainingPlan;
use crate::settings::RunFolder;

/// Links predicted at a time when no time is taken.
const BATCH: usize = 64;

/// Returns the name in the tables, by which the paper's figures are put beside it.
pub fn title(kind: ModelKind) -> (&'static str, EntryKind) {
    let entry = match kind {
        ModelKind::MsMlp | ModelKind::AdvMlp => EntryKind::Ablation,
        _ => EntryKind::Model,
    };
    (kind.title(), entry)
}

/// The training of a model in a benchmark.
pub fn plan(config: &Config, kind: ModelKind, data: &Path) -> Result<TrainingPlan> {
    let preset = config.preset()?;
    let pretrained = match (kind, preset) {
        // Weights of full width do not fit narrower models.
        (_, Preset::Small) | (ModelKind::RadioUnet, _) => None,
        (ModelKind::VitReg, _) => config.pretrained.vit_b_16.clone(),
        _ => config.pretrained.resnet18.clone(),
    };
    Ok(TrainingPlan {
        model: kind,
        preset,
        image_size: config.image_size(kind),
        data: data.into(),
        training: config.training(kind)?,
        dev_maps: None,
        dev_limit: config.training.develop_links,
        score_every: None,
        mirror: false,
        limit: config.links(kind),
        device: config.device,
        initial: pretrained.map_or(InitialWeights::Random, InitialWeights::Backbone),
    })
}

/// Everything that decides a training; `data` is the hash of the data set's settings.
pub fn settings(plan: &TrainingPlan, data: &str) -> Value {
    json!({
        "data": data,
        "model": plan.model.name(),
        "preset": plan.preset.name(),
        "image_size": plan.image_size,
        "training": plan.training,
        "develop_links": plan.dev_limit,
        "links": plan.limit,
        "device": plan.device,
        "initial_weights": plan.initial.to_string(),
    })
}

/// Time that was spent on a training, in all its sittings.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Clock {
    seconds: f64,
}

/// Trains a model into the part's folder, or continues the training that is there.
pub fn train(
    part: &Part,
    plan: &TrainingPlan,
    fresh: bool,
    interrupted: &AtomicBool,
) -> Result<Training> {
    let (result, clock) = (
        part.folder().join("training.json"),
        part.folder().join("clock.json"),
    );
    let state = part.open(fresh)?;
    if state == State::Finished {
        return read_json(&result);
    }
    let folder = RunFolder::create(part.folder())?;
    let is_begun = state == State::Begun && folder.checkpoint().is_file();
    let before = match is_begun && clock.is_file() {
        true => read_json::<Clock>(&clock)?.seconds,
        false => 0.0,
    };
    let started = Instant::now();
    let mut run = plan.prepare(folder.clone(), is_begun)?;
    let made = run.train(interrupted);
    let seconds = before + started.elapsed().as_secs_f64();
    write_json(&clock, &Clock { seconds })?;
    made?;
    let training = Training {
        seconds,
        epochs: plan.training.epochs as u32,
        best_epoch: run.best_epoch().map(|epochs| epochs as u32),
        links_seen: run.links_seen(),
        curve: curve(&folder)?,
    };
    write_json(&result, &training)?;
    part.finish()?;
    Ok(training)
}

/// The epochs as the run's log has them.
fn curve(folder: &RunFolder) -> Result<Vec<CurvePoint>> {
    let path = folder.scores();
    let place = || format!("log '{}'", path.display());
    let mut log = csv::Reader::from_path(&path).with_context(place)?;
    let columns = log.headers().with_context(place)?.clone();
    let mut curve = Vec::new();
    for row in log.records() {
        let row = row.with_context(place)?;
        let cell = |name: &str| -> Option<f64> {
            let column = columns.iter().position(|c| c == name)?;
            row.get(column)?
                .parse()
                .ok()
                .filter(|x: &f64| x.is_finite())
        };
        let of = |metric: Metric| cell(&format!("dev_{}", metric.key()));
        curve.push(CurvePoint {
            epoch: cell("epochs").with_context(place)? as u32,
            train_loss: cell("train_loss").with_context(place)?,
            dev_cosine: of(Metric::Cosine),
            dev_mse: of(Metric::Mse),
        });
    }
    Ok(curve)
}

/// Test links, device and timing by which a trained model is measured.
pub struct Question<'a> {
    /// The data set.
    pub dataset: &'a Dataset,
    /// Its test links.
    pub test: &'a TestSet,
    /// Settings of the measurement of run times.
    pub latency: &'a LatencyConfig,
    /// Device to compute on.
    pub device: &'a candle_core::Device,
    /// Set by Ctrl-C.
    pub interrupted: &'a AtomicBool,
}

/// Predicts the test links with the best weights, and measures the time that takes.
pub fn ask(
    plan: &TrainingPlan,
    training: Training,
    weights: &Path,
    asked: &Question<'_>,
) -> Result<Answer> {
    let label = Label {
        kind: plan.model,
        preset: plan.preset,
    };
    let (model, parameters) = network::load(weights, label, asked.device)?;
    let maps = asked.test.maps().iter().copied();
    let buildings = Buildings::load(asked.dataset, maps)?;
    let input = buildings.input(plan.model, false, plan.image_size, asked.device)?;
    let links = asked.test.labels().links();
    let mut predictions = Vec::with_capacity(links.len() * ANGLE_BINS);
    predict(
        &*model,
        &*input,
        links.iter().copied(),
        BATCH,
        |_, spectra| {
            if asked.interrupted.load(Ordering::Relaxed) {
                bail!("interrupted");
            }
            predictions.extend_from_slice(spectra);
            anyhow::Ok(())
        },
    )?;
    Ok(Answer {
        predictions,
        parameters: Some(parameters as u64),
        training: Some(training),
        latency: latency::of_model(&*model, &*input, links, asked.latency, asked.device)?,
        ..Answer::default()
    })
}
