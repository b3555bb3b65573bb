//! One training from its first, or next, step to its last: weights, logs and checkpoints in a folder.

use std::fs::{self, File};
use std::num::NonZeroU64;

use aps_metrics::{GroupReport, Metric};
use aps_model::train::{StepReport, TrainError, Trainer};
use aps_model::weights::{self, Label, LoadReport};
use serde::{Deserialize, Serialize};

use super::log::Log;
use super::score::Development;
use super::selection::cost;
use super::{RunFolder, Settings, TrainingError, rows};
use crate::control::{Control, DevelopmentScores, Work};
use crate::error::{At, Error, Place, Result};

/// Steps between two checkpoints within an epoch.
const STEPS_BETWEEN_CHECKPOINTS: NonZeroU64 = NonZeroU64::new(1000).unwrap();

/// Shares of a time budget after which the development links are scored: few, since scores take of that time, and doubling, as
/// curves over a logarithmic axis want them.
const SCORED_SHARES: [f64; 6] = [1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 1.0 / 2.0, 3.0 / 4.0, 1.0];

/// State of a run beside the training itself; kept in its checkpoints.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct State {
    /// Steps made before the last score; 0 without any.
    scored_at: u64,
    /// Bits of the sum of the losses since then: JSON would round them.
    loss_bits: u64,
    /// Steps made before the best score so far, and its [`cost`] as bits.
    best: Option<(u64, u64)>,
}

impl State {
    /// Steps made before the last score, if there is one.
    pub fn last_scored(&self) -> Option<u64> {
        (self.scored_at > 0).then_some(self.scored_at)
    }

    /// True if there are weights that did best so far.
    pub fn has_best(&self) -> bool {
        self.best.is_some()
    }
}

/// Scores of the development links at the end of a run.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ClosingScores {
    /// Epochs made before the best weights.
    pub best_epochs: f64,
    /// Number of development links.
    pub links: usize,
    /// Scores of the best weights.
    pub best: GroupReport,
    /// Scores of the mean of the training targets, which needs no training.
    pub mean: GroupReport,
}

/// A run from its first, or next, step to its last.
#[derive(Debug)]
pub struct Run {
    pub(super) label: Label,
    pub(super) folder: RunFolder,
    pub(super) settings: Settings,
    pub(super) initial: Option<LoadReport>,
    pub(super) trainer: Trainer,
    pub(super) state: State,
    pub(super) steps: Log,
    pub(super) scores: Log,
    pub(super) times: Log,
    pub(super) score_every: Option<NonZeroU64>,
    pub(super) development: Development,
    /// Metric by which the best weights are chosen.
    pub(super) chosen_by: Metric,
    pub(super) mean_target: Vec<f64>,
    /// Lock of the folder, kept as long as the run may write into it.
    pub(super) _lock: File,
}

impl Run {
    /// Makes all steps that are left, and scores the last weights: after the end of a time budget, whose time is for steps and
    /// earlier scores. A cancelled run saves everything first.
    ///
    /// # Errors
    /// [`TrainingError::Interrupted`], a time budget that is spent before the first step, steps that cannot be made, files that
    /// cannot be written.
    pub fn train(&mut self, control: &Control<'_>) -> Result<()> {
        let links = self.trainer.links_per_step() as u64;
        let budget_s = self.trainer.config().budget_s;
        let (units, name) = match (self.trainer.steps_total(), budget_s) {
            (Some(steps), _) => (steps * links, "links"),
            (None, budget_s) => (budget_s.unwrap_or_default().ceil() as u64, "seconds"),
        };
        control.progress.begin(Work {
            units,
            name,
            finished_maps: 0,
            maps: 0,
        });
        let done_at = |share: f64| (share * units as f64).round() as u64;
        let mut share = self.trainer.share();
        control.progress.advance(done_at(share));
        if self.trainer.steps_done() == 0 {
            // So that a run that fails at once has something to go back to.
            self.save()?;
        }
        while let Some(report) = self.step(control)? {
            control.progress.step(&report);
            control
                .progress
                .advance(done_at(report.share) - done_at(share));
            let passed = |&of: &f64| share < of && of <= report.share;
            let ends_part = match budget_s {
                None => report.ends_epoch,
                Some(_) => SCORED_SHARES.iter().any(passed),
            };
            share = report.share;
            let done = self.trainer.steps_done();
            let is_due = |every: NonZeroU64| done.is_multiple_of(every.get());
            if ends_part || self.score_every.is_some_and(is_due) {
                control.progress.scored(&self.evaluate()?);
            }
            if ends_part || is_due(STEPS_BETWEEN_CHECKPOINTS) {
                self.save()?;
            }
        }
        if self.trainer.steps_done() == 0 {
            // The time is spent, so that there is nothing to continue: the folder can be begun anew.
            let checkpoint = self.folder.checkpoint();
            fs::remove_file(&checkpoint).at_file(Place::File, &checkpoint)?;
            return Err(TrainingError::NoStep(self.trainer.seconds()).into());
        }
        // A checkpoint, or the scores before, took the time that was left.
        if self.state.scored_at < self.trainer.steps_done() {
            control.progress.scored(&self.evaluate()?);
            self.save()?;
        }
        Ok(())
    }

    /// Every setting of the run.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Account of the initial weights that a file gave.
    pub fn initial_weights(&self) -> Option<&LoadReport> {
        self.initial.as_ref()
    }

    /// The training itself.
    pub fn trainer(&self) -> &Trainer {
        &self.trainer
    }

    /// Steps after which the scores of the development links were best.
    pub fn best_steps(&self) -> Option<u64> {
        self.state.best.map(|(steps, _)| steps)
    }

    /// Number of links trained on, repeats counted.
    pub fn links_seen(&self) -> u64 {
        self.trainer.steps_done() * self.trainer.links_per_step() as u64
    }

    /// Loads the best weights, and scores them beside the mean of the training targets.
    ///
    /// # Errors
    /// [`TrainingError::NoEpoch`] when no score was made; weights that cannot be read.
    pub fn closing_scores(&self) -> Result<ClosingScores> {
        let best_steps = self.best_steps().ok_or(TrainingError::NoEpoch)?;
        // The last weights are in the checkpoint.
        weights::load(&self.folder.best(), self.trainer.parameters())?;
        Ok(ClosingScores {
            best_epochs: self.epochs(best_steps),
            links: self.development.examples.list().len(),
            best: self.score()?,
            mean: self.development.score_constant(&self.mean_target)?,
        })
    }

    fn epochs(&self, steps: u64) -> f64 {
        steps as f64 / self.trainer.steps_per_epoch() as f64
    }

    /// Makes one step, with its row in the log.
    fn step(&mut self, control: &Control<'_>) -> Result<Option<StepReport>> {
        if control.is_cancelled() {
            self.save()?;
            return Err(TrainingError::Interrupted {
                done: self.trainer.steps_done(),
                total: self.trainer.steps_total(),
                folder: self.folder.path().into(),
            }
            .into());
        }
        let Some(report) = self.trainer.step()? else {
            return Ok(None);
        };
        let sum = f64::from_bits(self.state.loss_bits) + report.loss;
        self.state.loss_bits = sum.to_bits();
        self.steps.push(&rows::step_cells(&report))?;
        Ok(Some(report))
    }

    /// Evaluates the model on the development links and saves the weights if they are the best so far.
    fn evaluate(&mut self) -> Result<DevelopmentScores> {
        let seconds = self.trainer.seconds();
        let (steps, group) = (self.trainer.steps_done(), self.score()?);
        let cost = cost(&group, self.chosen_by);
        let sum = f64::from_bits(std::mem::take(&mut self.state.loss_bits));
        let loss = sum / (steps - self.state.scored_at) as f64;
        let epochs = self.epochs(steps);
        self.scores
            .push(&rows::score_cells(steps, epochs, loss, &group))?;
        self.scores.flush()?;
        self.times.push(&rows::time_cells(steps, seconds))?;
        self.times.flush()?;
        self.state.scored_at = steps;
        let best = self.state.best;
        let is_best = best.is_none_or(|(_, best)| cost < f64::from_bits(best));
        if is_best {
            let parameters = self.trainer.parameters();
            weights::save(&self.folder.best(), parameters, Some(self.label))?;
            self.state.best = Some((steps, cost.to_bits()));
        }
        Ok(DevelopmentScores {
            steps,
            epochs,
            seconds,
            loss,
            group,
            chosen_by: self.chosen_by,
            is_best,
        })
    }

    fn score(&self) -> Result<GroupReport> {
        let batch = self.trainer.config().batch;
        let scored = self.development.score(self.trainer.model(), batch);
        scored.map_err(|error| match error.cause() {
            Error::Train(TrainError::Prediction { .. }) => {
                TrainingError::Diverged(self.trainer.steps_done()).into()
            }
            _ => error,
        })
    }

    fn save(&mut self) -> Result<()> {
        // Steps before a checkpoint must be in the log when the run is continued from it.
        self.steps.flush()?;
        let notes = serde_json::to_string(&self.state)?;
        Ok(self.trainer.save(self.folder.checkpoint(), &notes)?)
    }
}
