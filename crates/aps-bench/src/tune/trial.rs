//! A training with some settings, and what came of it.

use aps_model::ModelKind;

use crate::config::ModelConfig;
use crate::error::Error;

/// Settings of a model that were tried, or chosen.
#[derive(Debug, Clone, Copy)]
pub struct Trial<'a> {
    /// The model.
    pub model: ModelKind,
    /// Its settings.
    pub settings: ModelConfig,
    /// Share of the budget that it was trained for.
    pub share: f64,
    /// Result of the training.
    pub outcome: Outcome<'a>,
}

/// Result of a training with some settings.
#[derive(Debug, Clone, Copy)]
pub enum Outcome<'a> {
    /// A model was trained and scored.
    Scored {
        /// Its mean cosine similarity on development links.
        cosine: f64,
        /// Number of its steps, if they are too few to say much.
        few_steps: Option<u64>,
    },
    /// The training failed.
    Failed(&'a Error),
}
