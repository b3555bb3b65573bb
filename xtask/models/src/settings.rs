//! The folder of a run, and the settings in its `config.json`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use aps_label::MeanStd;
use aps_model::train::TrainConfig;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::device::Device;

/// Every setting of a run; written for people and for `predict`, not read by `train`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Name of the model.
    pub model: String,
    /// Its sizes.
    pub preset: String,
    /// Rows and columns of condition images.
    pub image_size: usize,
    /// Standard deviation of their spots \[pixels of the raster\].
    pub sigma_px: f64,
    /// Initial weights: `random`, the file of the backbone, or that of the whole model.
    pub initial_weights: String,
    /// Device that the training ran on.
    pub device: Device,
    /// The data set's folder.
    pub data: PathBuf,
    /// Its settings, as its manifest has them.
    pub data_configuration: Value,
    /// Definition of labels and metrics.
    pub protocol: String,
    /// Statistics of linear relative power over the training maps, by which targets are normalised.
    pub training_statistics: MeanStd,
    /// Training maps.
    pub train_maps: Vec<u32>,
    /// Maps the best weights are chosen by.
    pub dev_maps: Vec<u32>,
    /// Number of training links.
    pub train_links: usize,
    /// True when the mirror images of each link were trained on too.
    #[serde(default)]
    pub mirrored: bool,
    /// Number of links the best weights are chosen by.
    pub dev_links: usize,
    /// Settings of the training.
    pub training: TrainConfig,
}

impl Settings {
    /// Reads the settings of the run whose folder a file of weights lies in; `None` if it lies in no run's folder.
    pub fn beside(weights: &Path) -> Result<Option<Self>> {
        let path = weights.with_file_name("config.json");
        if !path.is_file() {
            return Ok(None);
        }
        let place = || format!("'{}'", path.display());
        let text = fs::read_to_string(&path).with_context(place)?;
        serde_json::from_str(&text).map(Some).with_context(place)
    }
}

/// The files of a run.
#[derive(Debug, Clone)]
pub struct RunFolder(PathBuf);

impl RunFolder {
    /// Makes the folder if need be.
    pub fn create(path: &Path) -> Result<Self> {
        fs::create_dir_all(path).with_context(|| format!("cannot create '{}'", path.display()))?;
        Ok(Self(path.into()))
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Everything needed to continue.
    pub fn checkpoint(&self) -> PathBuf {
        self.0.join("last.safetensors")
    }

    /// The weights that did best on the development maps.
    pub fn best(&self) -> PathBuf {
        self.0.join("best.safetensors")
    }

    pub fn steps(&self) -> PathBuf {
        self.0.join("steps.csv")
    }

    pub fn scores(&self) -> PathBuf {
        self.0.join("scores.csv")
    }

    pub fn write_settings(&self, settings: &Settings) -> Result<()> {
        let path = self.0.join("config.json");
        let text = serde_json::to_string_pretty(settings)? + "\n";
        fs::write(&path, text).with_context(|| format!("cannot write '{}'", path.display()))
    }
}
