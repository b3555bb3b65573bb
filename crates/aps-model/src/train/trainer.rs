//! A training, step by step.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use candle_core::Tensor;

use super::checkpoint::{self, Header};
use super::order::{Order, Use, generator};
use super::prefetch::{Batch, Prefetch};
use super::recipe::{Fault, Learner, Lesson};
use super::{TrainConfig, TrainError, Trainees};
use crate::condition::Conditions;
use crate::data::Examples;
use crate::optim::Schedule;
use crate::{ANGLE_BINS, Model};

/// A training, driven [`step`](Self::step) by step.
///
/// Memory beside the networks, three times their weights, and what a step's gradients take: the examples, and at most
/// four batches of targets.
#[derive(Debug)]
pub struct Trainer {
    learner: Learner,
    conditions: Conditions,
    examples: Arc<dyn Examples>,
    config: TrainConfig,
    order: Order,
    schedule: Schedule,
    /// Steps made.
    steps: u64,
    prefetch: Option<Prefetch>,
    checkpoint: Option<PathBuf>,
    failed: bool,
}

/// Report of one training step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepReport {
    /// Number of the step, from 0.
    pub step: u64,
    /// Epoch of the step, from 0.
    pub epoch: u64,
    /// True for the last step of an epoch.
    pub ends_epoch: bool,
    /// Links of the batch.
    pub links: usize,
    /// Learning rate.
    pub learning_rate: f64,
    /// Error of the predictions before the step: mean squared, or mean absolute with a regularizer.
    pub loss: f64,
    /// Norm of the predictor's gradients before clipping.
    pub gradient_norm: f64,
    /// Loss of the regularizer, if there is one; 2 ln 2 = 1.39 if it cannot tell predictions from truth.
    pub regularizer_loss: Option<f64>,
    /// Norm of the regularizer's gradients before clipping.
    pub regularizer_gradient_norm: Option<f64>,
}

impl Trainer {
    /// Prepares a training from the networks as they are.
    ///
    /// # Errors
    /// [`TrainError::Config`], [`TrainError::NoExamples`].
    pub fn new(
        trainees: Trainees,
        conditions: Conditions,
        examples: impl Examples + 'static,
        config: TrainConfig,
    ) -> Result<Self, TrainError> {
        if let Some(problem) = config.problem() {
            return Err(TrainError::Config(problem));
        }
        if examples.is_empty() {
            return Err(TrainError::NoExamples);
        }
        if u32::try_from(examples.len()).is_err() {
            let problem = format!("{} examples are more than can be numbered", examples.len());
            return Err(TrainError::Config(problem));
        }
        Ok(Self {
            learner: Learner::new(trainees, &config)?,
            order: Order::new(config.seed, examples.len(), config.batch),
            schedule: config.schedule(examples.len()),
            conditions,
            examples: Arc::new(examples),
            config,
            steps: 0,
            prefetch: None,
            checkpoint: None,
            failed: false,
        })
    }

    /// Makes the next step; `None` after the last.
    ///
    /// # Errors
    /// [`TrainError::Diverged`] and [`TrainError::Model`] end the training: every later call is [`TrainError::Failed`].
    pub fn step(&mut self) -> Result<Option<StepReport>, TrainError> {
        if self.failed {
            return Err(TrainError::Failed);
        }
        if self.steps == self.schedule.total {
            return Ok(None);
        }
        let (step, total) = (self.steps, self.schedule.total);
        let start = || Prefetch::start(Arc::clone(&self.examples), self.order.clone(), step, total);
        let batch = self.prefetch.get_or_insert_with(start).next();
        let learnt = self.learn(&batch);
        self.failed = learnt.is_err();
        let outcome = learnt.map_err(|fault| self.error_of(fault, &batch))?;
        self.steps += 1;
        let per_epoch = self.order.steps_per_epoch();
        Ok(Some(StepReport {
            step,
            epoch: step / per_epoch,
            ends_epoch: self.steps.is_multiple_of(per_epoch),
            links: batch.links.len(),
            learning_rate: self.schedule.at(step),
            loss: outcome.loss,
            gradient_norm: outcome.gradient_norm,
            regularizer_loss: outcome.regularizer.map(|r| r.loss),
            regularizer_gradient_norm: outcome.regularizer.map(|r| r.gradient_norm),
        }))
    }

    fn learn(&mut self, batch: &Batch) -> Result<super::recipe::Outcome, Fault> {
        let shape = (batch.links.len(), ANGLE_BINS);
        let generator = Mutex::new(generator(self.config.seed, Use::Dropout, self.steps));
        let lesson = Lesson {
            images: self.conditions.images(&batch.links)?,
            targets: Tensor::from_slice(&batch.targets, shape, self.conditions.device())?,
            generator: &generator,
            learning_rate: self.schedule.at(self.steps),
        };
        self.learner.step(&lesson, &self.config)
    }

    fn error_of(&self, fault: Fault, batch: &Batch) -> TrainError {
        match fault {
            Fault::Model(error) => error.into(),
            Fault::Diverged {
                quantity,
                value,
                errors,
            } => {
                let mut worst: Vec<usize> = (0..batch.links.len()).collect();
                // In the total order NaN is above all numbers, whatever its sign was.
                worst.sort_by(|&a, &b| errors[b].abs().total_cmp(&errors[a].abs()));
                let named = |i: usize| (batch.examples[i] as usize, batch.links[i]);
                TrainError::Diverged {
                    step: self.steps,
                    quantity,
                    value,
                    links: worst.into_iter().map(named).collect(),
                    checkpoint: self.checkpoint.clone(),
                }
            }
        }
    }

    /// Writes everything a [`resume`](Self::resume) needs into one safetensors file: weights, running statistics, moments
    /// of the optimizers, the step; and `notes` of the caller. An older file of this name is there until the new one is
    /// whole on disk.
    ///
    /// # Errors
    /// [`TrainError::Io`], [`TrainError::Failed`].
    pub fn save(&mut self, path: impl AsRef<Path>, notes: &str) -> Result<(), TrainError> {
        if self.failed {
            return Err(TrainError::Failed);
        }
        let (path, header) = (path.as_ref(), self.header(notes));
        checkpoint::save(path, &header, self.learner.networks())?;
        self.checkpoint = Some(path.into());
        Ok(())
    }

    /// Continues from a checkpoint of a training with the same settings, examples and kinds of networks; returns its notes.
    /// Later steps are, bit for bit, the steps that the checkpoint's training would have made.
    ///
    /// # Errors
    /// [`TrainError::Checkpoint`], [`TrainError::Io`]; nothing has then changed.
    pub fn resume(&mut self, path: impl AsRef<Path>) -> Result<String, TrainError> {
        let (path, own) = (path.as_ref(), self.header(""));
        let header = checkpoint::load(path, &own, self.schedule.total, self.learner.networks())?;
        self.steps = header.steps;
        self.prefetch = None;
        self.failed = false;
        self.checkpoint = Some(path.into());
        Ok(header.notes)
    }

    fn header(&self, notes: &str) -> Header {
        Header {
            steps: self.steps,
            config: self.config.clone(),
            image_size: self.conditions.image_size(),
            examples: self.examples.len(),
            links: checkpoint::digest(&*self.examples),
            notes: notes.into(),
        }
    }

    /// Returns the model as trained so far.
    pub fn predictor(&self) -> &dyn Model {
        self.learner.predictor()
    }

    /// Returns the maker of the condition images.
    pub fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// Returns the settings.
    pub fn config(&self) -> &TrainConfig {
        &self.config
    }

    /// Returns the number of steps made, steps before a resume included.
    pub fn steps_done(&self) -> u64 {
        self.steps
    }

    /// Returns the number of steps of the whole training.
    pub fn steps_total(&self) -> u64 {
        self.schedule.total
    }

    /// Returns the number of links in a batch.
    pub fn links_per_step(&self) -> usize {
        self.order.batch()
    }

    /// Returns the number of steps of an epoch.
    pub fn steps_per_epoch(&self) -> u64 {
        self.order.steps_per_epoch()
    }
}
