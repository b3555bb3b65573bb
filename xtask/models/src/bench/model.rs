//! The models: trained, then asked for the test links.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Context, Result};
use aps_metrics::Metric;
use aps_model::candle_core;
use aps_model::condition::Link;
use aps_model::{ANGLE_BINS, ModelKind, Preset};
use aps_report::benchmark::{CurvePoint, EntryKind, Training};
use map2aps::training::{InitialWeights, RunFolder, Trained, Training as Plan};
use map2aps::{Dataset, Error};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::answer::Answer;
use super::config::{Config, LatencyConfig};
use super::latency;
use super::stamp::{Part, State, read_json, write_json};
use super::test_set::TestSet;
use crate::run;

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
pub fn plan(config: &Config, kind: ModelKind) -> Result<Plan> {
    let preset = config.preset()?;
    let pretrained = match (kind, preset) {
        // Weights of full width do not fit narrower models.
        (_, Preset::Small) | (ModelKind::RadioUnet, _) => None,
        (ModelKind::VitReg, _) => config.pretrained.vit_b_16.clone(),
        _ => config.pretrained.resnet18.clone(),
    };
    Ok(Plan {
        model: kind,
        preset,
        image_size: config.image_size(kind),
        config: config.training(kind)?,
        development_links: config.training.develop_links,
        links: config.links(kind),
        device: config.device,
        initial: pretrained.map_or(InitialWeights::Random, InitialWeights::Backbone),
        ..Plan::new(kind, preset)
    })
}

/// Everything that decides a training; `data` is the hash of the data set's settings.
pub fn settings(plan: &Plan, data: &str) -> Value {
    json!({
        "data": data,
        "model": plan.model.name(),
        "preset": plan.preset.name(),
        "image_size": plan.image_size,
        "training": plan.config,
        "develop_links": plan.development_links,
        "links": plan.links,
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
    plan: &Plan,
    dataset: &Dataset,
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
    let made = run::train(plan, dataset, folder.clone(), is_begun, interrupted);
    let seconds = before + started.elapsed().as_secs_f64();
    write_json(&clock, &Clock { seconds })?;
    let run = made?;
    let training = Training {
        seconds,
        epochs: plan.config.epochs as u32,
        best_epoch: run.best_epochs().map(|epochs| epochs as u32),
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
    /// The test links.
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
    plan: &Plan,
    training: Training,
    weights: &Path,
    asked: &Question<'_>,
) -> Result<Answer> {
    let (kind, preset) = (Some(plan.model), Some(plan.preset));
    let trained = Trained::load(weights, kind, preset, asked.device)?.with_maps(plan.maps.clone());
    let examples = asked.test.examples();
    let input = trained.input(examples, plan.image_size)?;
    let mut predictions = Vec::with_capacity(examples.list().len() * ANGLE_BINS);
    trained.predict_batches(&*input, examples, BATCH, |spectra| {
        if asked.interrupted.load(Ordering::Relaxed) {
            return Err(Error::Cancelled);
        }
        predictions.extend_from_slice(spectra);
        Ok(())
    })?;
    let links: Vec<Link> = examples.links().collect();
    Ok(Answer {
        predictions,
        parameters: Some(trained.parameters() as u64),
        training: Some(training),
        latency: latency::of_model(
            trained.model(),
            &*input,
            &links,
            asked.latency,
            asked.device,
        )?,
        ..Answer::default()
    })
}
