//! Settings of a training.

use candle_core::{DType, Tensor};
use serde::{Deserialize, Serialize};

use super::schedule::{Budget, Schedule};
use crate::condition::InputShape;
use crate::named::named;
use crate::optim::AdamConfig;

/// Numbers that a network is trained with. Weights, normalisations, softmax, losses and the optimizer are in f32 always.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Everything in f32.
    #[default]
    Full,
    /// Inputs, activations and factors of products in bf16, whose sums are f32: what the tensor cores of a GPU multiply several
    /// times as fast. On a CPU it is slower than [`Full`](Self::Full), and there to be tested.
    Mixed,
}

impl Precision {
    /// Turns an input of a shape, in f32, into the type that the network takes it in. Ways along rays stay in f32, and so does all of
    /// Polar-Reg: bf16 has no room for the numbers of their directions.
    ///
    /// # Errors
    /// Memory that the device does not have.
    pub fn of_input(self, input: &Tensor, shape: InputShape) -> candle_core::Result<Tensor> {
        match (self, shape) {
            (Self::Mixed, InputShape::Images) => input.to_dtype(DType::BF16),
            (Self::Full, _) | (Self::Mixed, InputShape::Polar(_)) => Ok(input.clone()),
        }
    }
}

named!(Precision, "precision": Full = "full", Mixed = "mixed");

/// Settings of a training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainConfig {
    /// Number of passes over the examples; at least 1. Not used with [`budget_s`](Self::budget_s).
    pub epochs: u64,
    /// Wall time of the training \[s\]: everything between its first and its last step counts, what the caller does between
    /// steps too. No step is begun after it. Such a training does not give the same bytes twice.
    #[serde(default)]
    pub budget_s: Option<f64>,
    /// Links of a batch; cut to the number of examples. An epoch leaves out the remainder that does not fill a batch, other
    /// links each time.
    pub batch: usize,
    /// Highest learning rate, of both networks.
    pub learning_rate: f64,
    /// Steps on which the learning rate rises; at most a tenth of the training is used for it.
    pub warmup_steps: u64,
    /// The optimizer, of both networks.
    pub optimizer: AdamConfig,
    /// Largest norm of all gradients of a network; longer ones are shortened to it. Infinity, `null` in JSON, shortens none.
    #[serde(with = "finite_or_none")]
    pub clip_norm: f64,
    /// Weight of the mean absolute error beside the regularizer's score; not used without one.
    pub l1_weight: f64,
    /// A prediction error above this ends the training. Normalised targets have unit variance: predicting their mean has
    /// an error of 1.
    pub largest_loss: f64,
    /// Seed of order and dropout.
    pub seed: u64,
    /// Numbers of the networks.
    #[serde(default)]
    pub precision: Precision,
}

impl TrainConfig {
    /// Returns the paper's settings for models without regularizer: AdamW, 3e-4, 512 links a step.
    pub fn regression() -> Self {
        Self {
            epochs: 20,
            budget_s: None,
            batch: 512,
            learning_rate: 3e-4,
            warmup_steps: 500,
            optimizer: AdamConfig::default(),
            clip_norm: 1.0,
            l1_weight: 0.0,
            largest_loss: 1e4,
            seed: 42,
            precision: Precision::Full,
        }
    }

    /// Returns the paper's settings for models with a regularizer: Adam with beta1 = 0.5, 2e-4, 1024 links a step, absolute
    /// error times 100.
    pub fn adversarial() -> Self {
        Self {
            batch: 1024,
            learning_rate: 2e-4,
            optimizer: AdamConfig::adversarial(),
            l1_weight: 100.0,
            ..Self::regression()
        }
    }

    /// Returns the schedule of the learning rate over a run of epochs of so many steps.
    pub(super) fn schedule(&self, steps_per_epoch: u64) -> Schedule {
        Schedule {
            peak: self.learning_rate,
            warmup: self.warmup_steps,
            budget: match self.budget_s {
                Some(seconds) => Budget::Seconds(seconds),
                None => Budget::Steps(self.epochs.saturating_mul(steps_per_epoch)),
            },
        }
    }

    /// Describes a fault of the settings; `None` if they are sound.
    pub(super) fn problem(&self) -> Option<String> {
        let adam = &self.optimizer;
        let positive = |name, x: f64| {
            let is_good = x > 0.0 && x.is_finite();
            (!is_good).then(|| format!("{name} is {x}: must be positive and finite"))
        };
        let at_least_one = |name, n: u64| (n == 0).then(|| format!("{name} must be at least 1"));
        at_least_one("epochs", self.epochs)
            .or_else(|| at_least_one("batch", self.batch as u64))
            .or_else(|| self.budget_s.and_then(|s| positive("budget_s", s)))
            .or_else(|| positive("learning_rate", self.learning_rate))
            .or_else(|| {
                let x = self.clip_norm;
                let text = || format!("clip_norm is {x}: must be positive (infinity clips nothing)");
                (x.is_nan() || x <= 0.0).then(text)
            })
            .or_else(|| positive("largest_loss", self.largest_loss))
            .or_else(|| positive("epsilon", adam.epsilon))
            .or_else(|| {
                let shares = [adam.beta1, adam.beta2].iter().all(|b| (0.0..1.0).contains(b));
                let weights = [adam.weight_decay, self.l1_weight].iter().all(|w| (0.0..f64::INFINITY).contains(w));
                (!(shares && weights)).then(|| {
                    "beta1 and beta2 must be in [0, 1), weight_decay and l1_weight finite and not negative".into()
                })
            })
    }
}

/// A number that may be infinite, which JSON has no word for: none.
mod finite_or_none {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(x: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        x.is_finite().then_some(*x).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
    }
}
