//! The models: trained, then asked for the test links.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use aps_metrics::Metric;
use aps_model::condition::Link;
use aps_model::{ANGLE_BINS, ModelKind, Preset};
use aps_report::benchmark::{CurvePoint, Training};
use map2aps::maps::MapSource;
use map2aps::training::{InitialWeights, RunFolder, Selection, Trained, Training as Plan};
use serde_json::{Value, json};

use crate::answer::Answer;
use crate::config::{Config, LatencyConfig};
use crate::error::{Error, Result};
use crate::files::{read_json, write_json};
use crate::latency;
use crate::part::{Part, State};
use crate::test_bed::TestBed;
use crate::watch::{Event, Watch};

/// Metric by which the weights of every model are chosen: the one that entries are ranked by.
pub const CHOSEN_BY: Metric = Metric::Cosine;

/// Links predicted at a time when no time is taken.
const BATCH: usize = 64;

/// The training of a model in a benchmark; `maps` are those that its data set is made from, for a model that is given the geometry.
fn plan(config: &Config, kind: ModelKind, maps: &MapSource) -> Result<Plan> {
    let preset = config.training.preset;
    let pretrained = match (kind, preset) {
        // Weights of full width do not fit narrower models.
        (_, Preset::Small) | (ModelKind::RadioUnet, _) => None,
        (ModelKind::VitReg, _) => config.pretrained.vit_b_16.clone(),
        (
            ModelKind::MsAreg
            | ModelKind::MsMlp
            | ModelKind::AdvMlp
            | ModelKind::ResnetMlp
            | ModelKind::ResnetConv1d
            | ModelKind::PolarReg,
            Preset::Paper,
        ) => config.pretrained.resnet18.clone(),
    };
    Ok(Plan {
        model: kind,
        preset,
        image_size: config.image_size(kind),
        config: config.training(kind)?,
        development_links: config.training.develop_links,
        selection: Selection::Metric(CHOSEN_BY),
        links: config.training.links,
        device: config.device,
        maps: Some(maps.clone()),
        initial: pretrained.map_or(InitialWeights::Random, InitialWeights::Backbone),
        ..Plan::new(kind, preset)
    })
}

/// Settings that decide a training; `data` is the hash of the data set's settings.
fn settings(plan: &Plan, data: &str) -> Value {
    json!({
        "data": data,
        "model": plan.model.name(),
        "preset": plan.preset.name(),
        "image_size": plan.image_size,
        "training": plan.config,
        "develop_links": plan.development_links,
        "chosen_by": plan.selection.metric(plan.model),
        "links": plan.links,
        "device": plan.device,
        "initial_weights": plan.initial.to_string(),
    })
}

impl TestBed {
    /// The training of a model in a folder.
    pub fn training(
        &self,
        config: &Config,
        kind: ModelKind,
        folder: &Path,
    ) -> Result<(Plan, Part)> {
        let plan = plan(config, kind, &self.plan.maps)?;
        let settings = settings(&plan, &self.data.hash);
        Ok((plan, Part::new(folder.into(), settings)))
    }

    /// Makes all steps of a training, or those that are left; a finished one is read.
    pub fn train(&self, plan: &Plan, part: &Part, watch: Watch<'_>) -> Result<Training> {
        let result = part.folder.join("training.json");
        let state = part.open(self.fresh, watch)?;
        if state == State::Finished {
            return read_json(&result);
        }
        let folder = RunFolder::create(&part.folder)?;
        let is_begun = state == State::Begun && folder.checkpoint().is_file();
        let mut run = plan.prepare(&self.dataset, folder.clone(), is_begun)?;
        watch.tell(Event::TrainingBegins(plan, &run));
        let made = run.train(&watch.control());
        let is_whole = made.is_ok();
        watch.tell(Event::TrainingEnds { is_whole });
        made?;
        let (trainer, curve) = (run.trainer(), curve(&folder)?);
        let training = Training {
            seconds: curve.last().map_or(0.0, |last| last.seconds),
            epochs: trainer.steps_done() as f64 / trainer.steps_per_epoch() as f64,
            best_steps: run.best_steps(),
            links_seen: run.links_seen(),
            batch: trainer.links_per_step(),
            learning_rate: plan.config.learning_rate,
            image_size: plan.image_size,
            curve,
        };
        write_json(&result, &training)?;
        part.finish()?;
        Ok(training)
    }

    /// Reads the best weights of a training.
    pub fn trained(&self, plan: &Plan, part: &Part) -> Result<Trained> {
        let weights = RunFolder::create(&part.folder)?.best();
        let (kind, preset) = (Some(plan.model), Some(plan.preset));
        let trained = Trained::load(&weights, kind, preset, &self.device)?;
        Ok(trained.with_maps(plan.maps.clone()))
    }

    /// Predicts the links with trained weights, and measures the time that takes.
    pub fn ask(
        &self,
        trained: &Trained,
        latency: &LatencyConfig,
        watch: Watch<'_>,
    ) -> Result<Answer> {
        let examples = &self.test.examples;
        let input = trained.input(examples, trained.images())?;
        let mut predictions = Vec::with_capacity(examples.list().len() * ANGLE_BINS);
        trained.predict_batches(&*input, examples, BATCH, |spectra| {
            if watch.is_cancelled() {
                return Err(map2aps::Error::Cancelled);
            }
            predictions.extend_from_slice(spectra);
            Ok(())
        })?;
        let links: Vec<Link> = examples.links().collect();
        let (model, device) = (trained.model(), &self.device);
        let fresh = || Ok(trained.input(examples, trained.images())?);
        Ok(Answer {
            predictions,
            model: Some(trained.label().kind),
            parameters: Some(trained.parameters() as u64),
            latency: latency::of_model(model, &*input, &fresh, &links, latency, device)?,
            ..Answer::default()
        })
    }
}

/// The scores of the development links as the run's logs have them; those whose time no row tells, as after a log was moved away, are left
/// out.
fn curve(folder: &RunFolder) -> Result<Vec<CurvePoint>> {
    let rows = |path: PathBuf| -> Result<Vec<HashMap<String, f64>>> {
        let mut log = csv::Reader::from_path(&path).map_err(Error::file("log", &path))?;
        let rows: Result<_, csv::Error> = log.deserialize().collect();
        rows.map_err(Error::file("log", &path))
    };
    let (scores, times) = (rows(folder.scores())?, rows(folder.times())?);
    let steps_of = |row: &HashMap<String, f64>| row.get("steps").map(|&steps| steps as u64);
    let point = |scores: &HashMap<String, f64>| {
        let steps = steps_of(scores)?;
        let time = times.iter().find(|time| steps_of(time) == Some(steps))?;
        let cell = |name: &str| scores.get(name).copied();
        let of = |metric: Metric| {
            let value = cell(&format!("dev_{}", metric.key()));
            value.filter(|x| x.is_finite())
        };
        Some(CurvePoint {
            steps,
            seconds: *time.get("seconds")?,
            train_loss: cell("train_loss").unwrap_or_default(),
            dev_cosine: of(Metric::Cosine),
            dev_recall: of(Metric::Recall4Deg),
        })
    };
    Ok(scores.iter().filter_map(point).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_have_the_times_of_their_steps_where_a_log_was_begun_anew() {
        let root = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(root.path()).unwrap();
        let scores = ["10,0.3", "20,0.2", "30,0.1"];
        let times = ["10,1.5", "20,2.5", "30,3.5"];
        let found = |scores: &[&str], times: &[&str]| {
            let write = |path: PathBuf, columns: &str, rows: &[&str]| {
                std::fs::write(path, [&[columns], rows].concat().join("\n")).unwrap();
            };
            write(folder.scores(), "steps,train_loss", scores);
            write(folder.times(), "steps,seconds", times);
            let points = curve(&folder).unwrap().into_iter();
            points
                .map(|point| (point.steps, point.seconds, point.train_loss))
                .collect::<Vec<_>>()
        };
        let whole = found(&scores, &times);
        assert_eq!(whole, [(10, 1.5, 0.3), (20, 2.5, 0.2), (30, 3.5, 0.1)]);
        assert_eq!(found(&scores[1..], &times), whole[1..]);
        assert_eq!(found(&scores, &times[2..]), whole[2..]);
    }
}
