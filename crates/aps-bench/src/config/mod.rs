//! Settings of a benchmark.

mod check;
mod profile;
mod resolve;
mod training;

use std::collections::BTreeMap;
use std::path::PathBuf;

use aps_label::Protocol;
use aps_model::{ModelKind, Preset};
use map2aps::Limits;
use map2aps::training::Device;
use serde::{Deserialize, Serialize};

pub use profile::Profile;

/// Every setting of a benchmark.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Seed of terminals, synthetic cities, weights, order and drawn links.
    pub seed: u64,
    /// Models in the order of their training; all if not given.
    #[serde(default = "every_model")]
    pub models: Vec<ModelKind>,
    /// Device of the models.
    pub device: Device,
    /// The data set.
    pub data: DataConfig,
    /// Training of every model.
    pub training: TrainingConfig,
    /// The tracer as a baseline.
    pub tracer: TracerConfig,
    /// Measurement of run times.
    pub latency: LatencyConfig,
    /// Settings of single models, by name.
    #[serde(default)]
    pub model: BTreeMap<String, ModelConfig>,
    /// Weights that backbones begin with.
    #[serde(default)]
    pub pretrained: Pretrained,
    /// Weights trained before, scored as they are, by the name they get in the tables.
    #[serde(default)]
    pub weights: BTreeMap<String, PathBuf>,
    /// Predictions from elsewhere, by the name they get in the tables.
    #[serde(default)]
    pub external: BTreeMap<String, PathBuf>,
}

/// Data that models learn from and are scored on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataConfig {
    /// `synthetic`, or a folder of footprint files 0.json, 1.json, ...
    pub maps: String,
    /// Maps to learn from.
    pub train_maps: usize,
    /// Maps to choose the best weights by.
    pub develop_maps: usize,
    /// Maps to score on.
    pub test_maps: usize,
    /// Transmitters a map.
    pub tx_per_map: usize,
    /// Receivers a map, shared by its transmitters.
    pub rx_per_map: usize,
    /// Definition of the labels.
    pub protocol: Protocol,
    /// Limits of the paths in labels.
    pub limits: Limits,
    /// Test links scored, drawn by the seed; all if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub test_links: Option<usize>,
}

/// Settings of the training of models.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingConfig {
    /// `paper` or `small`.
    pub preset: Preset,
    /// Time of each model: `60s`, `10m`, `1h`. Without it `epochs` end a training.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub budget: Option<String>,
    /// Times each link is learnt from; the model's own in the paper if neither this nor `budget` is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epochs: Option<u64>,
    /// Links to learn from, drawn by the seed; all if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub links: Option<usize>,
    /// Development links scored each time, drawn by the seed; all if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub develop_links: Option<usize>,
    /// Settings of every model for which [`Config::model`] says nothing else.
    #[serde(flatten)]
    pub all: ModelConfig,
}

/// Settings of a model; those that are not given are the paper's, and the image size that of the preset.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ModelConfig {
    /// Rows and columns of condition images \[pixels\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub image_size: Option<usize>,
    /// Batch size \[links\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub batch: Option<usize>,
    /// Highest learning rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learning_rate: Option<f64>,
    /// Steps on which the learning rate rises, within a tenth of the training.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub warmup_steps: Option<u64>,
}

/// Settings with which the tracer is scored against the labels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TracerConfig {
    /// Most interactions on a path: an entry each. A number above that of the labels stands for that of the labels.
    pub interactions: Vec<usize>,
}

/// Settings of the measurement of run times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LatencyConfig {
    /// Links predicted at once, ascending.
    pub batches: Vec<usize>,
    /// Time spent on each of them \[s\]; a few repetitions are made in any case.
    pub seconds: f64,
}

/// torchvision weights.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pretrained {
    /// Weights for the models with a ResNet-18 of full width.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resnet18: Option<PathBuf>,
    /// Weights for `vit_reg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vit_b_16: Option<PathBuf>,
}

fn every_model() -> Vec<ModelKind> {
    ModelKind::ALL.to_vec()
}
