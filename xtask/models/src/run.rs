//! One training from its first, or next, step to its last: weights, logs and checkpoints in a folder.

use std::num::NonZeroU64;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, bail, ensure};
use aps_metrics::{GroupReport, Metric};
use aps_model::condition::ConditionConfig;
use aps_model::data::{Examples, Mirrored};
use aps_model::train::{StepReport, TrainConfig, Trainer};
use aps_model::weights::{self, Label};
use aps_model::{ModelKind, Preset};
use indicatif::{ProgressBar, ProgressStyle};
use serde::{Deserialize, Serialize};

use crate::data::{self, Buildings, DevMaps};
use crate::device::Device;
use crate::journal::Journal;
use crate::labels::Labels;
use crate::network::{InitialWeights, Networks};
use crate::rows;
use crate::score::{self, Development};
use crate::settings::{RunFolder, Settings};
use xtask::{note, say};

/// Steps between two checkpoints within an epoch.
const STEPS_BETWEEN_CHECKPOINTS: NonZeroU64 = NonZeroU64::new(1000).unwrap();

/// Model, data and settings of a training.
#[derive(Debug, Clone)]
pub struct TrainingPlan {
    /// The model to train.
    pub model: ModelKind,
    /// Its sizes.
    pub preset: Preset,
    /// Rows and columns of condition images \[pixels\].
    pub image_size: usize,
    /// Folder of the data set.
    pub data: PathBuf,
    /// Settings of the training.
    pub training: TrainConfig,
    /// Maps to choose the best weights by; none for the data set's.
    pub dev_maps: Option<DevMaps>,
    /// Development links scored each time, drawn by the seed; none for all.
    pub dev_limit: Option<usize>,
    /// Steps between two scores of the development links, beside the one at the end of each epoch.
    pub score_every: Option<NonZeroU64>,
    /// Links to train on, drawn by the seed; none for all.
    pub limit: Option<usize>,
    /// If true, the model is trained on the mirror images of each link too.
    pub mirror: bool,
    /// Device to compute on.
    pub device: Device,
    /// Initial weights.
    pub initial: InitialWeights,
}

/// State of a run beside the training itself; kept in its checkpoints.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Progress {
    /// Scores that are written.
    scores: u64,
    /// Steps made before the last of them.
    scored_at: u64,
    /// Bits of the sum of the losses since then: JSON would round them.
    loss_bits: u64,
    /// Steps made before the best score so far, and its error as bits.
    best: Option<(u64, u64)>,
}

impl TrainingPlan {
    /// Opens the data and builds the networks; with `resume` they continue from the folder's checkpoint.
    pub fn prepare(&self, folder: RunFolder, resume: bool) -> Result<Run> {
        let device = self.device.open()?;
        let dataset = data::open(&self.data)?;
        let (train_maps, dev_maps) =
            data::divide(&dataset.manifest().split, self.dev_maps.as_ref())?;
        let (protocol, training_statistics, normalization) = data::target(&dataset)?;
        let all = train_maps.iter().chain(&dev_maps).copied();
        let image_size = self.image_size;
        let buildings = Buildings::load(&dataset, all)?;
        let input = buildings.input(self.model, self.mirror, image_size, &device)?;
        let seed = self.training.seed;
        let load = |maps: &[u32], limit| {
            Labels::load(
                &dataset,
                maps,
                &buildings.index_of,
                limit,
                seed,
                normalization,
            )
        };
        let train = load(&train_maps, self.limit)?;
        let dev = load(&dev_maps, self.dev_limit)?;
        let counts = [train.rows().len(), dev.rows().len()];
        ensure!(
            counts[0] > 0,
            "the training maps {train_maps:?} have no link with a label"
        );
        ensure!(
            counts[1] > 0,
            "the development maps {dev_maps:?} have no link with a label"
        );

        let label = Label {
            kind: self.model,
            preset: self.preset,
        };
        let settings = Settings {
            model: self.model.to_string(),
            preset: self.preset.to_string(),
            image_size,
            sigma_px: ConditionConfig::default().sigma_px,
            initial_weights: self.initial.to_string(),
            device: self.device,
            data: self.data.clone(),
            data_configuration: dataset.manifest().configuration.clone(),
            protocol: protocol.to_string(),
            training_statistics,
            train_maps,
            dev_maps,
            train_links: counts[0],
            mirrored: self.mirror,
            dev_links: counts[1],
            training: self.training.clone(),
        };
        let mean_spectrum = score::mean_spectrum(&train);
        let train: Box<dyn Examples> = match self.mirror {
            false => Box::new(train),
            true => {
                let manifest = dataset.manifest();
                let aps = manifest.layout.aps.context("no spectra are stored")?;
                let negated = data::negated_bins(&manifest.configuration, aps.axis)?;
                Box::new(Mirrored::new(train, buildings.rasters(), negated)?)
            }
        };
        let networks = Networks::new(label, seed, &self.initial, &device)?;
        let (model, parameters) = networks.model;
        let config = self.training.clone();
        let mut trainer = Trainer::new(model, &parameters, input, train, config)?;
        if let Some((regularizer, parameters)) = networks.regularizer {
            trainer = trainer.with_regularizer(regularizer, &parameters)?;
        }
        let progress = match resume {
            true => serde_json::from_str(&trainer.resume(folder.checkpoint())?)
                .context("notes of the checkpoint")?,
            false => Progress::default(),
        };
        folder.write_settings(&settings)?;
        let steps = Journal::open(folder.steps(), &rows::step_columns(), trainer.steps_done())?;
        let scores = Journal::open(folder.scores(), &rows::score_columns(), progress.scores)?;
        note!(
            "{} ({}, weights: {}), {} training links of {} maps, {} development links of {} maps, images {image_size} x {image_size}, {} steps of {} links",
            settings.model,
            settings.preset,
            settings.initial_weights,
            settings.train_links,
            settings.train_maps.len(),
            settings.dev_links,
            settings.dev_maps.len(),
            trainer.steps_total(),
            trainer.links_per_step(),
        );
        Ok(Run {
            label,
            folder,
            trainer,
            progress,
            steps,
            scores,
            score_every: self.score_every,
            development: Development::new(dev, protocol),
            mean_spectrum,
        })
    }
}

/// A run from its first, or next, step to its last.
pub struct Run {
    label: Label,
    folder: RunFolder,
    trainer: Trainer,
    progress: Progress,
    steps: Journal,
    scores: Journal,
    score_every: Option<NonZeroU64>,
    development: Development,
    mean_spectrum: Vec<f64>,
}

impl Run {
    /// Makes all steps that are left; on Ctrl-C everything is saved and the run ends with an error that says so.
    pub fn train(&mut self, interrupted: &AtomicBool) -> Result<()> {
        let bar = progress_bar(&self.trainer);
        if self.trainer.steps_done() == 0 {
            // So that a run that fails at once has something to go back to.
            self.save()?;
        }
        while let Some(report) = self.step(&bar, interrupted)? {
            bar.set_message(format!(
                "epoch {}, loss {:.4}",
                report.epoch + 1,
                report.loss
            ));
            let done = self.trainer.steps_done();
            let is_due = |every: NonZeroU64| done.is_multiple_of(every.get());
            if report.ends_epoch || self.score_every.is_some_and(is_due) {
                self.evaluate(&bar)?;
            }
            if report.ends_epoch || is_due(STEPS_BETWEEN_CHECKPOINTS) {
                self.save()?;
            }
        }
        bar.finish_and_clear();
        Ok(())
    }

    /// Epochs after which the error on the development links was least.
    pub fn best_epoch(&self) -> Option<f64> {
        self.progress.best.map(|(steps, _)| self.epochs(steps))
    }

    /// Converts steps to epochs.
    fn epochs(&self, steps: u64) -> f64 {
        steps as f64 / self.trainer.steps_per_epoch() as f64
    }

    /// Number of links trained on, repeats counted.
    pub fn links_seen(&self) -> u64 {
        self.trainer.steps_done() * self.trainer.links_per_step() as u64
    }

    /// One step with its row in the log. On Ctrl-C everything is saved and the run ends with an error that says so.
    fn step(&mut self, bar: &ProgressBar, interrupted: &AtomicBool) -> Result<Option<StepReport>> {
        if interrupted.load(Ordering::Relaxed) {
            bar.abandon();
            self.save()?;
            bail!(
                "interrupted after {} of {} steps, all of which are kept in '{}'",
                self.trainer.steps_done(),
                self.trainer.steps_total(),
                self.folder.path().display()
            );
        }
        let Some(report) = self.trainer.step()? else {
            return Ok(None);
        };
        let sum = f64::from_bits(self.progress.loss_bits) + report.loss;
        self.progress.loss_bits = sum.to_bits();
        self.steps.push(&rows::step_cells(&report))?;
        bar.inc(report.links as u64);
        Ok(Some(report))
    }

    /// Evaluates the model on the development set and saves the weights if they are the best so far.
    fn evaluate(&mut self, bar: &ProgressBar) -> Result<()> {
        bar.set_message("scoring");
        let (steps, scores) = (self.trainer.steps_done(), self.score()?);
        let error = score::mean(&scores, self.chosen_by());
        let sum = f64::from_bits(std::mem::take(&mut self.progress.loss_bits));
        let loss = sum / (steps - self.progress.scored_at) as f64;
        let epochs = self.epochs(steps);
        self.scores
            .push(&rows::score_cells(steps, epochs, loss, &scores))?;
        self.scores.flush()?;
        self.progress.scores += 1;
        self.progress.scored_at = steps;
        let is_best = self
            .progress
            .best
            .is_none_or(|(_, best)| error < f64::from_bits(best));
        if is_best {
            let parameters = self.trainer.parameters();
            weights::save(&self.folder.best(), parameters, Some(self.label))?;
            self.progress.best = Some((steps, error.to_bits()));
        }
        bar.println(format!(
            "{} epochs, {steps} steps: training loss {loss:.4}; development {} {error:.4}, CosSim {:.4}, PLE {:.2} deg{}",
            short(epochs),
            self.chosen_by().label(),
            score::mean(&scores, Metric::Cosine),
            score::mean(&scores, Metric::PleDeg),
            if is_best { ", best" } else { "" }
        ));
        Ok(())
    }

    fn score(&self) -> Result<GroupReport> {
        let (model, input) = (self.trainer.model(), self.trainer.input());
        self.development
            .score(model, input, self.trainer.config().batch)
    }

    fn save(&mut self) -> Result<()> {
        // Steps before a checkpoint must be in the log when the run is continued from it.
        self.steps.flush()?;
        let notes = serde_json::to_string(&self.progress)?;
        Ok(self.trainer.save(self.folder.checkpoint(), &notes)?)
    }

    /// Returns the metric by which the best weights are chosen: the one that training minimises.
    fn chosen_by(&self) -> Metric {
        match self.label.kind.is_adversarial() {
            true => Metric::Mae,
            false => Metric::Mse,
        }
    }

    /// Prints the scores of the best weights beside those of the mean training spectrum, which needs no training.
    pub fn print_scores(&self) -> Result<()> {
        let Some((steps, _)) = self.progress.best else {
            bail!("no epoch has ended");
        };
        // The last weights are in the checkpoint.
        weights::load(&self.folder.best(), self.trainer.parameters())?;
        let best = self.score()?;
        let mean = self.development.score_constant(&self.mean_spectrum)?;
        let rows = [
            (format!("best, epoch {}", short(self.epochs(steps))), &best),
            ("mean training spectrum".to_owned(), &mean),
        ];
        say!(
            "{} development links:\n{}",
            self.development.len(),
            score::table(&rows)
        )?;
        say!("best weights in '{}'", self.folder.best().display())?;
        let cosine = |group| score::mean(group, Metric::Cosine);
        if cosine(&best) <= cosine(&mean) {
            say!(
                "WARNING: the model's spectra are no more like the true ones (CosSim) than the mean training spectrum is: \
                 it has not learnt; give it more links or epochs"
            )?;
        }
        Ok(())
    }
}

/// A number of epochs with two decimals, or none if it is whole.
fn short(epochs: f64) -> String {
    match epochs.fract() == 0.0 {
        true => epochs.to_string(),
        false => format!("{epochs:.2}"),
    }
}

/// Counts links.
fn progress_bar(trainer: &Trainer) -> ProgressBar {
    let style = ProgressStyle::with_template(
        "[{bar:30}] {human_pos}/{human_len} links, {per_sec}, {eta} left, {msg}",
    )
    .expect("the template is well formed")
    .progress_chars("=> ");
    let batch = trainer.links_per_step() as u64;
    let bar = ProgressBar::new(trainer.steps_total() * batch).with_style(style);
    // Links of an earlier run do not count for the speed.
    bar.set_position(trainer.steps_done() * batch);
    bar.reset_eta();
    bar
}
