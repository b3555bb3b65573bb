//! A training, step by step.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use candle_core::{DType, Tensor};
use candle_nn::{Optimizer, VarMap};

use super::batches::{Batch, Order, Prefetch};
use super::checkpoint::{self, Header, Optimized};
use super::clock::Clock;
use super::held::HeldTargets;
use super::schedule::{Budget, Schedule};
use super::{TrainConfig, TrainError};
use crate::condition::ModelInput;
use crate::data::Examples;
use crate::loss::{Loss, bce_with_logits};
use crate::{ANGLE_BINS, Model, Regularizer};

/// A training, driven [`step`](Self::step) by step.
///
/// Memory beside the networks, three times their weights, and what a step's gradients take: the examples, and at most
/// four batches of targets.
pub struct Trainer {
    model: Box<dyn Model>,
    regularizer: Option<Regularizer>,
    loss: Loss,
    /// Parameters and optimizer of the model, then of the regularizer if there is one.
    networks: Vec<Optimized>,
    input: Arc<dyn ModelInput>,
    examples: Arc<dyn Examples>,
    /// Targets of the examples, if they lie on the device.
    targets: Option<HeldTargets>,
    held: Held,
    config: TrainConfig,
    order: Order,
    schedule: Schedule,
    /// Steps made.
    steps: u64,
    clock: Clock,
    prefetch: Option<Prefetch>,
    checkpoint: Option<PathBuf>,
    failed: bool,
}

/// Parts of all examples that lie on the device: see [`Trainer::hold`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Held {
    /// Targets.
    pub targets: bool,
    /// Material of inputs other than the maps: see [`ModelInput::hold`].
    pub input: bool,
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
    /// Share of the training's budget that is spent, this step included, from 0 to 1.
    pub share: f64,
    /// Links of the batch.
    pub links: usize,
    /// Learning rate.
    pub learning_rate: f64,
    /// Error of the predictions before the step: the loss, or the mean absolute error with a regularizer.
    pub loss: f64,
    /// Norm of the predictor's gradients before clipping.
    pub gradient_norm: f64,
    /// Loss of the regularizer, if there is one; 2 ln 2 = 1.39 if it cannot tell predictions from truth.
    pub regularizer_loss: Option<f64>,
    /// Norm of the regularizer's gradients before clipping.
    pub regularizer_gradient_norm: Option<f64>,
}

/// Reason for which a step was not made.
enum StepError {
    Model(crate::Error),
    /// A loss or the norm of gradients is not finite, or too large.
    Diverged(&'static str, f64),
}

impl<E: Into<crate::Error>> From<E> for StepError {
    fn from(error: E) -> Self {
        Self::Model(error.into())
    }
}

impl Trainer {
    /// Prepares a training of `model`, whose tensors are those of `parameters`, from the weights as they are, by the loss of its
    /// [kind](crate::ModelKind::loss) or another.
    ///
    /// # Errors
    /// [`TrainError::Config`], also without any example.
    pub fn new(
        model: Box<dyn Model>,
        parameters: &VarMap,
        loss: Loss,
        input: Box<dyn ModelInput>,
        examples: Box<dyn Examples>,
        config: TrainConfig,
    ) -> Result<Self, TrainError> {
        if let Some(problem) = config.problem() {
            return Err(TrainError::Config(problem));
        }
        if examples.is_empty() {
            return Err(TrainError::Config("there is no example to train on".into()));
        }
        if u32::try_from(examples.len()).is_err() {
            let problem = format!("{} examples are more than can be numbered", examples.len());
            return Err(TrainError::Config(problem));
        }
        let order = Order::new(config.seed, examples.len(), config.batch);
        let order = order.grouped(&*examples, &*input);
        Ok(Self {
            model,
            regularizer: None,
            loss,
            networks: vec![Optimized::new("predictor", parameters, &config)?],
            schedule: config.schedule(order.steps_per_epoch()),
            order,
            input: Arc::from(input),
            examples: Arc::from(examples),
            targets: None,
            held: Held::default(),
            config,
            steps: 0,
            clock: Clock::new(),
            prefetch: None,
            checkpoint: None,
            failed: false,
        })
    }

    /// Puts the targets of all examples onto the device, in half precision: 360 bytes an example, if that is not more than 8 GiB and
    /// there is room; and what their input is made of, if that [can be held](ModelInput::hold). Batches then send the numbers of their
    /// examples instead; [`held`](Self::held) tells what is. On a CPU it saves nothing.
    ///
    /// # Errors
    /// [`TrainError::Model`] for failures of the device, and errors of the input.
    pub fn hold(mut self) -> Result<Self, TrainError> {
        let mut links = (0..self.examples.len()).map(|example| self.examples.link(example));
        self.held.input = self.input.hold(&mut links)?;
        self.targets = HeldTargets::new(&*self.examples, self.input.device())?;
        self.held.targets = self.targets.is_some();
        Ok(self)
    }

    /// Returns which parts lie on the device.
    pub fn held(&self) -> Held {
        self.held
    }

    /// Trains by the absolute error against a regularizer, whose tensors are those of `parameters`.
    ///
    /// # Errors
    /// [`TrainError::Config`] when they hold no trainable tensors.
    pub fn with_regularizer(
        mut self,
        regularizer: Regularizer,
        parameters: &VarMap,
    ) -> Result<Self, TrainError> {
        self.networks.truncate(1);
        let network = Optimized::new("regularizer", parameters, &self.config)?;
        self.networks.push(network);
        self.regularizer = Some(regularizer);
        self.loss = Loss::Adversarial;
        Ok(self)
    }

    /// Replaces the clock of a time budget by one that counts from any moment.
    #[cfg(test)]
    pub(crate) fn with_clock(mut self, now: impl Fn() -> Duration + Send + Sync + 'static) -> Self {
        self.clock.now = Box::new(now);
        self
    }

    /// Counts time that was spent on the training before its first step here, as on loading its examples.
    pub fn spend(&mut self, time: Duration) {
        self.clock.before += time;
    }

    /// Makes the next step; `None` after the last.
    ///
    /// # Errors
    /// [`TrainError::Diverged`] and [`TrainError::Model`] end the training: every later call is [`TrainError::Failed`].
    pub fn step(&mut self) -> Result<Option<StepReport>, TrainError> {
        if self.failed {
            return Err(TrainError::Failed);
        }
        self.clock.start();
        let seconds = self.seconds();
        if self.schedule.share(self.steps, seconds) >= 1.0 {
            return Ok(None);
        }
        let (step, end) = (self.steps, self.steps_total().unwrap_or(u64::MAX));
        let start = || {
            let (examples, input) = (Arc::clone(&self.examples), Arc::clone(&self.input));
            let (order, needs_targets) = (self.order.clone(), self.targets.is_none());
            Prefetch::start(examples, input, order, step..end, needs_targets)
        };
        let batch = self.prefetch.get_or_insert_with(start).next();
        let report = self.train_on(&batch, self.schedule.at(step, seconds));
        self.failed = report.is_err();
        self.steps += u64::from(report.is_ok());
        let share = self.share();
        report.map(|report| Some(StepReport { share, ..report }))
    }

    /// Trains on a batch: input, forward pass, losses, updates. No weight changes unless every loss and gradient that would
    /// change it is finite.
    fn train_on(&mut self, batch: &Batch, learning_rate: f64) -> Result<StepReport, TrainError> {
        let precision = self.config.precision;
        let input = self.input.batch(&batch.links)?;
        let input = precision.of_input(&input, self.input.shape())?;
        let shape = (batch.links.len(), ANGLE_BINS);
        let targets = match &self.targets {
            Some(held) => held.of(&batch.examples)?,
            None => Tensor::from_slice(&batch.targets, shape, self.input.device())?,
        };
        self.model.seed_dropout(self.config.seed, self.steps);
        let predicted = self.model.forward_t(&input, true)?.to_dtype(DType::F32)?;
        for network in &mut self.networks {
            network.optimizer.set_learning_rate(learning_rate);
        }
        let updated = self.update(&input, &predicted, &targets, learning_rate);
        updated.map_err(|error| match error {
            StepError::Model(error) => error.into(),
            StepError::Diverged(quantity, value) => {
                self.diverged(batch, &predicted, &targets, quantity, value)
            }
        })
    }

    fn update(
        &mut self,
        input: &Tensor,
        predicted: &Tensor,
        targets: &Tensor,
        learning_rate: f64,
    ) -> Result<StepReport, StepError> {
        let error = self.loss.error(predicted, targets)?;
        let per_epoch = self.order.steps_per_epoch();
        let mut report = StepReport {
            step: self.steps,
            epoch: self.steps / per_epoch,
            ends_epoch: (self.steps + 1).is_multiple_of(per_epoch),
            share: 0.0,
            links: self.order.batch(),
            learning_rate,
            loss: self.value(&error, "the loss")?,
            gradient_norm: 0.0,
            regularizer_loss: None,
            regularizer_gradient_norm: None,
        };
        let loss = match self.regularizer.clone() {
            None => error,
            Some(regularizer) => {
                let score = |encoded: &Tensor, spectra: &Tensor| {
                    let spectra = spectra.to_dtype(encoded.dtype())?;
                    regularizer.score(encoded, &spectra)?.to_dtype(DType::F32)
                };
                let encoded = regularizer.encode(input, true)?;
                let real = score(&encoded, targets)?;
                let fake = score(&encoded, &predicted.detach())?;
                let loss = (bce_with_logits(&real, &real.ones_like()?)?
                    + bce_with_logits(&fake, &fake.zeros_like()?)?)?;
                report.regularizer_loss = Some(self.value(&loss, "the regularizer's loss")?);
                let norm = self.descend(1, &loss, "the norm of the regularizer's gradient")?;
                report.regularizer_gradient_norm = Some(norm);
                // The encoding by the updated regularizer is a constant to the predictor.
                let encoded = regularizer.encode(input, true)?.detach();
                let fake = score(&encoded, predicted)?;
                let adversarial = bce_with_logits(&fake, &fake.ones_like()?)?;
                (adversarial + (error * self.config.l1_weight)?)?
            }
        };
        report.gradient_norm = self.descend(0, &loss, "the gradient's norm")?;
        Ok(report)
    }

    /// Updates the parameters of a network by the clipped gradients of `loss`; returns the norm before clipping.
    fn descend(
        &mut self,
        network: usize,
        loss: &Tensor,
        of: &'static str,
    ) -> Result<f64, StepError> {
        let optimizer = &mut self.networks[network].optimizer;
        let norm = optimizer.backward_step_clipped(loss, self.config.clip_norm)?;
        match norm.is_finite() {
            true => Ok(norm),
            false => Err(StepError::Diverged(of, norm)),
        }
    }

    /// Returns the value of a loss, if training can go on from it.
    fn value(&self, loss: &Tensor, quantity: &'static str) -> Result<f64, StepError> {
        let value = f64::from(loss.to_dtype(DType::F32)?.to_scalar::<f32>()?);
        match value.abs() <= self.config.largest_loss {
            true => Ok(value),
            false => Err(StepError::Diverged(quantity, value)),
        }
    }

    /// Returns the error that names the links of the batch, the worst predicted first.
    fn diverged(
        &self,
        batch: &Batch,
        predicted: &Tensor,
        targets: &Tensor,
        quantity: &'static str,
        value: f64,
    ) -> TrainError {
        let errors = || -> candle_core::Result<Vec<f32>> {
            let difference = (predicted.detach() - targets)?;
            difference.abs()?.mean(1)?.to_dtype(DType::F32)?.to_vec1()
        };
        let errors = match errors() {
            Ok(errors) => errors,
            Err(error) => return error.into(),
        };
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

    /// Writes everything a [`resume`](Self::resume) needs into one safetensors file: weights, running statistics, moments
    /// of the optimizers, the step; and `notes` of the caller. An older file of this name is there until the new one is
    /// whole on disk.
    ///
    /// # Errors
    /// [`Error::WeightsIo`](crate::Error::WeightsIo), [`TrainError::Failed`].
    pub fn save(&mut self, path: impl AsRef<Path>, notes: &str) -> Result<(), TrainError> {
        if self.failed {
            return Err(TrainError::Failed);
        }
        let (path, header) = (path.as_ref(), self.header(notes));
        checkpoint::save(path, &header, self.networks.iter())?;
        self.checkpoint = Some(path.into());
        Ok(())
    }

    /// Continues from a checkpoint of a training with the same settings, examples and kinds of networks; returns its notes.
    /// Later steps are, bit for bit, the steps that the checkpoint's training would have made.
    ///
    /// # Errors
    /// [`TrainError::Checkpoint`], [`Error::WeightsIo`](crate::Error::WeightsIo); nothing has then changed.
    pub fn resume(&mut self, path: impl AsRef<Path>) -> Result<String, TrainError> {
        let (path, own) = (path.as_ref(), self.header(""));
        // Half of all numbers where time ends the training, so that a step more is a number too.
        let total = self.steps_total().unwrap_or(u64::MAX / 2);
        let header = checkpoint::load(path, &own, total, self.networks.iter_mut())?;
        self.steps = header.steps;
        self.clock.since = None;
        self.clock.before = Duration::from_secs_f64(header.seconds.unwrap_or_default());
        self.prefetch = None;
        self.failed = false;
        self.checkpoint = Some(path.into());
        Ok(header.notes)
    }

    fn header(&self, notes: &str) -> Header {
        Header {
            steps: self.steps,
            seconds: self.config.budget_s.map(|_| self.seconds()),
            config: self.config.clone(),
            image_size: self.input.image_size(),
            examples: self.examples.len(),
            links: checkpoint::digest(&*self.examples),
            notes: notes.into(),
        }
    }

    /// Returns the model as trained so far.
    pub fn model(&self) -> &dyn Model {
        &*self.model
    }

    /// Returns the tensors of the model.
    pub fn parameters(&self) -> &VarMap {
        &self.networks[0].parameters
    }

    /// Returns the maker of the model's input.
    pub fn input(&self) -> &dyn ModelInput {
        &*self.input
    }

    /// Returns the settings.
    pub fn config(&self) -> &TrainConfig {
        &self.config
    }

    /// Returns the number of steps made, steps before a resume included.
    pub fn steps_done(&self) -> u64 {
        self.steps
    }

    /// Returns the number of steps of the whole training; `None` where time ends it.
    pub fn steps_total(&self) -> Option<u64> {
        match self.schedule.budget {
            Budget::Steps(total) => Some(total),
            Budget::Seconds(_) => None,
        }
    }

    /// Returns the time since the first step, and before it what was [spent](Self::spend) \[s\]; of a training with a time
    /// budget, in all its sittings.
    pub fn seconds(&self) -> f64 {
        self.clock.seconds()
    }

    /// Returns the share of the budget, of steps or of time, that is spent, from 0 to 1.
    pub fn share(&self) -> f64 {
        self.schedule.share(self.steps, self.seconds())
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

impl fmt::Debug for Trainer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Trainer")
            .field("model", &self.model)
            .field("config", &self.config)
            .field("steps", &self.steps)
            .finish_non_exhaustive()
    }
}
