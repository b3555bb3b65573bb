//! A training with its logs, scores and checkpoints.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Result, bail};
use aps_metrics::{GroupReport, Metric};
use aps_model::train::{StepReport, Trainer};
use aps_model::weights::{self, Label};
use indicatif::{ProgressBar, ProgressStyle};
use serde::{Deserialize, Serialize};
use xtask::interrupt::interrupt_flag;

use crate::journal::Journal;
use crate::score::{self, Development};
use crate::settings::RunFolder;

/// Steps between two checkpoints within an epoch.
const STEPS_BETWEEN_CHECKPOINTS: u64 = 1000;

/// What a run knows beside the training itself; kept in its checkpoints.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Progress {
    /// Epochs whose scores are written.
    epochs: u64,
    /// Bits of the sum of the losses of this epoch's steps: JSON would round them.
    loss_bits: u64,
    /// The best epoch so far, and its error as bits.
    best: Option<(u64, u64)>,
}

/// A run from its first, or next, step to its last.
pub struct Run {
    label: Label,
    folder: RunFolder,
    trainer: Trainer,
    progress: Progress,
    steps: Journal,
    epochs: Journal,
    development: Development,
    mean_spectrum: Vec<f64>,
}

impl Run {
    /// Opens the logs of a training that stands where `progress` says.
    pub fn new(
        label: Label,
        folder: RunFolder,
        trainer: Trainer,
        progress: Progress,
        development: Development,
        mean_spectrum: Vec<f64>,
    ) -> Result<Self> {
        let steps = Journal::open(folder.steps(), &step_columns(), trainer.steps_done())?;
        let epochs = Journal::open(folder.epochs(), &epoch_columns(), progress.epochs)?;
        Ok(Self {
            label,
            folder,
            trainer,
            progress,
            steps,
            epochs,
            development,
            mean_spectrum,
        })
    }

    /// Trains to the end, or until Ctrl-C.
    pub fn go(&mut self) -> Result<()> {
        let interrupted = interrupt_flag()?;
        let bar = progress_bar(&self.trainer);
        if self.trainer.steps_done() == 0 {
            // So that a run that fails at once has something to go back to.
            self.save()?;
        }
        while let Some(report) = self.step(&bar, &interrupted)? {
            bar.set_message(format!(
                "epoch {}, loss {:.4}",
                report.epoch + 1,
                report.loss
            ));
            if report.ends_epoch {
                self.end_epoch(&report, &bar)?;
            }
            let is_due = self
                .trainer
                .steps_done()
                .is_multiple_of(STEPS_BETWEEN_CHECKPOINTS);
            if report.ends_epoch || is_due {
                self.save()?;
            }
        }
        bar.finish_and_clear();
        self.close()
    }

    /// One step with its row in the log. On Ctrl-C everything is saved and the run ends with an error that says so.
    fn step(&mut self, bar: &ProgressBar, interrupted: &AtomicBool) -> Result<Option<StepReport>> {
        if interrupted.load(Ordering::Relaxed) {
            bar.abandon();
            self.save()?;
            bail!(
                "interrupted after {} of {} steps, all of which are kept in '{}'; the same command with --resume continues",
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
        self.steps.push(&step_cells(&report))?;
        bar.inc(report.links as u64);
        Ok(Some(report))
    }

    /// Scores the development links and keeps the weights if they are the best so far.
    fn end_epoch(&mut self, step: &StepReport, bar: &ProgressBar) -> Result<()> {
        bar.set_message(format!("epoch {}, scoring", step.epoch + 1));
        let scores = self.score()?;
        let error = score::mean(&scores, self.chosen_by());
        let sum = f64::from_bits(std::mem::take(&mut self.progress.loss_bits));
        let loss = sum / self.trainer.steps_per_epoch() as f64;
        self.epochs.push(&epoch_cells(step.epoch, loss, &scores))?;
        self.epochs.flush()?;
        self.progress.epochs = step.epoch + 1;
        let is_best = self
            .progress
            .best
            .is_none_or(|(_, best)| error < f64::from_bits(best));
        if is_best {
            let parameters = self.trainer.predictor().parameters();
            weights::save(&self.folder.best(), parameters, Some(self.label))?;
            self.progress.best = Some((step.epoch, error.to_bits()));
        }
        bar.println(format!(
            "epoch {:>3}: training loss {loss:.4}; development {} {error:.4}, CosSim {:.4}, PLE {:.2} deg{}",
            step.epoch + 1,
            self.chosen_by().label(),
            score::mean(&scores, Metric::Cosine),
            score::mean(&scores, Metric::PleDeg),
            if is_best { ", best" } else { "" }
        ));
        Ok(())
    }

    fn score(&self) -> Result<GroupReport> {
        let (model, conditions) = (self.trainer.predictor(), self.trainer.conditions());
        self.development
            .score(model, conditions, self.trainer.config().batch)
    }

    fn save(&mut self) -> Result<()> {
        // What a checkpoint has seen must be in the log when it is continued.
        self.steps.flush()?;
        let notes = serde_json::to_string(&self.progress)?;
        Ok(self.trainer.save(self.folder.checkpoint(), &notes)?)
    }

    /// The error by which the best epoch is chosen: the one the model is trained on.
    fn chosen_by(&self) -> Metric {
        match self.label.kind.is_adversarial() {
            true => Metric::Mae,
            false => Metric::Mse,
        }
    }

    /// What the best weights have learnt, beside what can be had without learning.
    fn close(&self) -> Result<()> {
        let Some((epoch, _)) = self.progress.best else {
            bail!("no epoch has ended");
        };
        // The last weights are in the checkpoint.
        weights::load(&self.folder.best(), self.trainer.predictor().parameters())?;
        let best = self.score()?;
        let mean = self.development.score_constant(&self.mean_spectrum)?;
        let rows = [
            (format!("best, epoch {}", epoch + 1), &best),
            ("mean training spectrum".to_owned(), &mean),
        ];
        println!(
            "{} development links:\n{}",
            self.development.len(),
            score::table(&rows)
        );
        println!("best weights in '{}'", self.folder.best().display());
        let cosine = |group| score::mean(group, Metric::Cosine);
        if cosine(&best) <= cosine(&mean) {
            println!(
                "WARNING: the model's spectra are no more like the true ones (CosSim) than the mean training spectrum is: \
                 it has not learnt; give it more links or epochs"
            );
        }
        Ok(())
    }
}

fn step_columns() -> Vec<String> {
    [
        "step",
        "epoch",
        "learning_rate",
        "loss",
        "gradient_norm",
        "regularizer_loss",
        "regularizer_gradient_norm",
    ]
    .map(str::to_owned)
    .into()
}

fn step_cells(report: &StepReport) -> [String; 7] {
    let optional = |x: Option<f64>| x.map(|x| x.to_string()).unwrap_or_default();
    [
        report.step.to_string(),
        report.epoch.to_string(),
        report.learning_rate.to_string(),
        report.loss.to_string(),
        report.gradient_norm.to_string(),
        optional(report.regularizer_loss),
        optional(report.regularizer_gradient_norm),
    ]
}

fn epoch_columns() -> Vec<String> {
    let metrics = Metric::ALL
        .iter()
        .map(|metric| format!("dev_{}", metric.key()));
    ["epoch", "train_loss"]
        .map(str::to_owned)
        .into_iter()
        .chain(metrics)
        .collect()
}

fn epoch_cells(epoch: u64, loss: f64, scores: &GroupReport) -> Vec<String> {
    let metrics = Metric::ALL
        .iter()
        .map(|&metric| score::mean(scores, metric).to_string());
    [epoch.to_string(), loss.to_string()]
        .into_iter()
        .chain(metrics)
        .collect()
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
