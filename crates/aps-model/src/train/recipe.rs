//! One step of learning.

use std::fmt::Debug;
use std::result::Result as StdResult;
use std::sync::Mutex;

use candle_core::{DType, Tensor};
use rand_chacha::ChaCha8Rng;

use super::{Quantity, TrainConfig};
use crate::optim::{Adam, clip_factor, gradient_norm};
use crate::{Mode, Model, Parameters, Regularizer, Result, loss};

/// A network that scores how well a spectrum suits a condition image, used in training only.
pub trait Regularize: Debug + Send + Sync {
    /// Encodes condition images (batch, 3, height, width) for [`score`](Self::score): (batch, features).
    fn encode(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor>;

    /// Scores spectra (batch, bins) under encoded images; returns logits, before the sigmoid: (batch, 1).
    fn score(&self, encoded: &Tensor, spectra: &Tensor) -> Result<Tensor>;

    /// Returns all tensors of the network, by their PyTorch names.
    fn parameters(&self) -> &Parameters;
}

impl Regularize for Regularizer {
    fn encode(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        self.encode(images, mode)
    }

    fn score(&self, encoded: &Tensor, spectra: &Tensor) -> Result<Tensor> {
        self.score(encoded, spectra)
    }

    fn parameters(&self) -> &Parameters {
        self.parameters()
    }
}

/// Networks to train.
#[derive(Debug)]
pub struct Trainees {
    /// Model to train.
    pub predictor: Box<dyn Model>,
    /// Regularizer of the predictor; without one the recipe is plain regression.
    pub regularizer: Option<Box<dyn Regularize>>,
}

/// Networks with their optimizers.
#[derive(Debug)]
pub struct Learner {
    trainees: Trainees,
    predictor: Adam,
    regularizer: Option<Adam>,
}

/// Loss and gradient norms of one step.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    pub loss: f64,
    pub gradient_norm: f64,
    pub regularizer: Option<RegularizerOutcome>,
}

#[derive(Debug, Clone, Copy)]
pub struct RegularizerOutcome {
    pub loss: f64,
    pub gradient_norm: f64,
}

/// Reason for which a step was not made.
pub enum Fault {
    Model(crate::Error),
    Diverged {
        quantity: Quantity,
        value: f64,
        /// Mean absolute error of each link of the batch.
        errors: Vec<f32>,
    },
}

impl<E: Into<crate::Error>> From<E> for Fault {
    fn from(error: E) -> Self {
        Self::Model(error.into())
    }
}

/// A batch on the device, and the random numbers of its step.
pub struct Lesson<'a> {
    pub images: Tensor,
    pub targets: Tensor,
    pub generator: &'a Mutex<ChaCha8Rng>,
    pub learning_rate: f64,
}

impl Learner {
    pub fn new(trainees: Trainees, config: &TrainConfig) -> Result<Self> {
        let adam = |parameters| Adam::new(parameters, config.optimizer);
        Ok(Self {
            predictor: adam(trainees.predictor.parameters())?,
            regularizer: match &trainees.regularizer {
                Some(regularizer) => Some(adam(regularizer.parameters())?),
                None => None,
            },
            trainees,
        })
    }

    pub fn predictor(&self) -> &dyn Model {
        &*self.trainees.predictor
    }

    /// Returns each network by name, with its tensors and optimizer.
    pub fn networks(&mut self) -> Vec<(&'static str, &Parameters, &mut Adam)> {
        let predictor = self.trainees.predictor.parameters();
        let mut all = vec![("predictor", predictor, &mut self.predictor)];
        if let (Some(network), Some(adam)) = (&self.trainees.regularizer, &mut self.regularizer) {
            all.push(("regularizer", network.parameters(), adam));
        }
        all
    }

    /// Learns from a batch. Nothing moves unless every loss and gradient that would move it is sound.
    pub fn step(&mut self, lesson: &Lesson<'_>, config: &TrainConfig) -> StdResult<Outcome, Fault> {
        let mode = Mode::Train(lesson.generator);
        let predicted = self.trainees.predictor.forward(&lesson.images, mode)?;
        let error = match self.regularizer {
            None => loss::mse(&predicted, &lesson.targets)?,
            Some(_) => loss::l1(&predicted, &lesson.targets)?,
        };
        let judge = Judge {
            predicted: &predicted,
            lesson,
            config,
        };
        let error_value = judge.value(&error, Quantity::Loss)?;
        let (goal, regularizer) = match (&self.trainees.regularizer, &mut self.regularizer) {
            (Some(network), Some(adam)) => {
                let outcome = judge.teach_regularizer(&**network, adam)?;
                // The encoding by the moved regularizer is a constant to the predictor.
                let encoded = network.encode(&lesson.images, mode)?.detach();
                let score = network.score(&encoded, &predicted)?;
                let fooled = loss::bce_with_logits(&score, &score.ones_like()?)?;
                ((fooled + (error * config.l1_weight)?)?, Some(outcome))
            }
            _ => (error, None),
        };
        let gradient_norm = judge.learn(&goal, &mut self.predictor, Quantity::Gradient)?;
        Ok(Outcome {
            loss: error_value,
            gradient_norm,
            regularizer,
        })
    }
}

/// Watches over one step.
struct Judge<'a> {
    predicted: &'a Tensor,
    lesson: &'a Lesson<'a>,
    config: &'a TrainConfig,
}

impl Judge<'_> {
    fn teach_regularizer(
        &self,
        network: &dyn Regularize,
        adam: &mut Adam,
    ) -> StdResult<RegularizerOutcome, Fault> {
        let mode = Mode::Train(self.lesson.generator);
        let encoded = network.encode(&self.lesson.images, mode)?;
        let real = network.score(&encoded, &self.lesson.targets)?;
        let predicted = network.score(&encoded, &self.predicted.detach())?;
        let loss = (loss::bce_with_logits(&real, &real.ones_like()?)?
            + loss::bce_with_logits(&predicted, &predicted.zeros_like()?)?)?;
        Ok(RegularizerOutcome {
            loss: self.value(&loss, Quantity::RegularizerLoss)?,
            gradient_norm: self.learn(&loss, adam, Quantity::RegularizerGradient)?,
        })
    }

    /// Moves the variables of `adam` down the gradient of `loss` and returns its norm.
    fn learn(&self, loss: &Tensor, adam: &mut Adam, quantity: Quantity) -> StdResult<f64, Fault> {
        let gradients = loss.backward()?;
        let norm = gradient_norm(&gradients, adam.variables())?;
        if !norm.is_finite() {
            return Err(self.diverged(quantity, norm));
        }
        let scale = clip_factor(norm, self.config.clip_norm);
        adam.step(&gradients, self.lesson.learning_rate, scale)?;
        Ok(norm)
    }

    /// Returns the value of a loss, if training can go on from it.
    fn value(&self, loss: &Tensor, quantity: Quantity) -> StdResult<f64, Fault> {
        let value = f64::from(loss.to_dtype(DType::F32)?.to_scalar::<f32>()?);
        match value.abs() <= self.config.largest_loss {
            true => Ok(value),
            false => Err(self.diverged(quantity, value)),
        }
    }

    fn diverged(&self, quantity: Quantity, value: f64) -> Fault {
        let errors = || -> Result<Vec<f32>> {
            let difference = (self.predicted.detach() - &self.lesson.targets)?;
            Ok(difference.abs()?.mean(1)?.to_dtype(DType::F32)?.to_vec1()?)
        };
        match errors() {
            Ok(errors) => Fault::Diverged {
                quantity,
                value,
                errors,
            },
            Err(error) => Fault::Model(error),
        }
    }
}
