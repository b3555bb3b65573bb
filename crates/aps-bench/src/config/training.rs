//! Settings of a model's training, made of those of a benchmark.

use std::collections::HashSet;

use aps_model::ModelKind;
use aps_model::train::TrainConfig;
use map2aps::training::usual_image_size;

use super::{Config, ModelConfig};
use crate::error::{Error, Result};

impl Config {
    /// The models, in order, each once.
    pub fn kinds(&self) -> Vec<ModelKind> {
        let mut seen = HashSet::new();
        let kinds = self.models.iter().copied();
        kinds.filter(|&kind| seen.insert(kind)).collect()
    }

    /// Time of each model's training \[s\]; none where epochs end it.
    ///
    /// # Errors
    /// Text that is no time.
    pub fn budget_s(&self) -> Result<Option<f64>> {
        let parse = |text: &String| {
            let bad = |told: String| Error::Setting(format!("training.budget '{text}': {told}"));
            match humantime::parse_duration(text) {
                Ok(time) if !time.is_zero() => Ok(time.as_secs_f64()),
                Ok(_) => Err(bad("must be above 0".into())),
                Err(error) => Err(bad(error.to_string())),
            }
        };
        self.training.budget.as_ref().map(parse).transpose()
    }

    /// Settings of one model, its own before those of all.
    pub fn model(&self, kind: ModelKind) -> ModelConfig {
        let own = self.model.get(kind.name()).copied().unwrap_or_default();
        let all = self.training.all;
        ModelConfig {
            image_size: own.image_size.or(all.image_size),
            batch: own.batch.or(all.batch),
            learning_rate: own.learning_rate.or(all.learning_rate),
            warmup_steps: own.warmup_steps.or(all.warmup_steps),
        }
    }

    /// Size of a model's condition images \[pixels\].
    pub fn image_size(&self, kind: ModelKind) -> usize {
        let usual = usual_image_size(self.training.preset);
        self.model(kind).image_size.unwrap_or(usual)
    }

    /// Settings of a model's training.
    ///
    /// # Errors
    /// As [`Config::budget_s`].
    pub fn training(&self, kind: ModelKind) -> Result<TrainConfig> {
        let (own, usual) = (self.model(kind), kind.train_config(self.training.preset));
        Ok(TrainConfig {
            epochs: self.training.epochs.unwrap_or(usual.epochs),
            budget_s: self.budget_s()?,
            batch: own.batch.unwrap_or(usual.batch),
            learning_rate: own.learning_rate.unwrap_or(usual.learning_rate),
            warmup_steps: own.warmup_steps.unwrap_or(usual.warmup_steps),
            seed: self.seed,
            precision: self.device.usual_precision(),
            ..usual
        })
    }
}
