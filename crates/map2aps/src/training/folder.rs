//! The folder of a run, and the settings in its `config.json`.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use aps_data::{Dataset, Difference};
use aps_label::{MeanStd, Normalization, Protocol};
use aps_model::condition::Frame;
use aps_model::train::TrainConfig;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Device, TrainingError};
use crate::error::{At, Place, Result};

/// Name of the file of the settings.
pub(super) const SETTINGS_FILE: &str = "config.json";

/// Every setting of a run; written for people and for prediction, read by training to tell that a run which is continued is the same.
///
/// Weights that another program trained, as those of `map2aps.torch.models.save`, have what predictions need: what only a run here knows is
/// empty then.
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
    /// Part of the plane that they show.
    #[serde(default)]
    pub frame: Frame,
    /// Initial weights: `random`, the file of the backbone, or that of the whole model.
    #[serde(default)]
    pub initial_weights: String,
    /// Device that the training ran on.
    #[serde(default)]
    pub device: Device,
    /// The data set's folder.
    pub data: PathBuf,
    /// Its settings, as its manifest has them.
    pub data_configuration: Value,
    /// Definition of labels and metrics.
    pub protocol: Protocol,
    /// Statistics of linear relative power over the training maps, by which targets are normalised.
    pub training_statistics: MeanStd,
    /// Training maps.
    #[serde(default)]
    pub train_maps: Vec<u32>,
    /// Maps the best weights are chosen by.
    #[serde(default)]
    pub dev_maps: Vec<u32>,
    /// Number of training links.
    #[serde(default)]
    pub train_links: usize,
    /// True when the mirror images of each link were trained on too.
    #[serde(default)]
    pub mirrored: bool,
    /// Number of links the best weights are chosen by.
    #[serde(default)]
    pub dev_links: usize,
    /// Key of the metric the best weights are chosen by; not told by runs of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chosen_by: Option<String>,
    /// Settings of the training; `None` for a training of another program.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub training: Option<TrainConfig>,
}

impl Settings {
    /// Reads the settings of the run whose folder a file of weights lies in; `None` if it lies in no run's folder.
    ///
    /// # Errors
    /// A file that cannot be read, or holds other settings.
    pub fn beside(weights: &Path) -> Result<Option<Self>> {
        let path = weights.with_file_name(SETTINGS_FILE);
        if !path.is_file() {
            return Ok(None);
        }
        let read = || Self::parse(&fs::read_to_string(&path)?);
        read().map(Some).at_file(Place::File, &path)
    }

    /// Settings by which the run that these are of is another than one with `now`.
    ///
    /// Device, folder of the data set and initial weights may change, and [`TrainConfig`] is compared with the checkpoint.
    pub(super) fn differences(&self, now: &Self) -> Result<Vec<Difference>> {
        let told = |settings: &Self| -> Result<Value> {
            let mut all = serde_json::to_value(settings)?;
            for free in ["device", "data", "initial_weights", "training"] {
                all[free].take();
            }
            if self.chosen_by.is_none() {
                all["chosen_by"].take();
            }
            Ok(all)
        };
        Ok(aps_data::differences(&told(self)?, &told(now)?))
    }

    /// Reads the settings in the text of a `config.json`.
    pub(super) fn parse(text: &str) -> Result<Self> {
        let settings: Self = serde_json::from_str(text)?;
        let MeanStd { mean, std } = settings.training_statistics;
        // What is predicted is in single precision.
        if !(mean.is_finite() && std > 0.0 && (1.0 / std) < f64::from(f32::MAX)) {
            return Err(TrainingError::Statistics { mean, std }.into());
        }
        match settings.sigma_px {
            sigma_px if sigma_px.is_finite() && sigma_px > 0.0 => Ok(settings),
            sigma_px => Err(TrainingError::SpotWidth(sigma_px).into()),
        }
    }

    /// Method by which the targets of the training were made.
    pub(super) fn normalization(&self) -> Normalization {
        Normalization::of(self.protocol, self.training_statistics)
    }
}

/// The files of a run.
#[derive(Debug, Clone)]
pub struct RunFolder(PathBuf);

impl RunFolder {
    /// Makes the folder if need be.
    ///
    /// # Errors
    /// A folder that cannot be made, and that of a data set.
    pub fn create(path: &Path) -> Result<Self> {
        if Dataset::is_at(path) {
            return Err(TrainingError::DatasetFolder(path.into()).into());
        }
        fs::create_dir_all(path).at_file(Place::Creating, path)?;
        Ok(Self(path.into()))
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Refuses a folder whose weights a new run would replace, and which holds no checkpoint to go on from.
    ///
    /// # Errors
    /// [`TrainingError::OnlyWeights`].
    pub fn check_for_new_run(&self) -> Result<()> {
        match self.best().exists() && !self.checkpoint().is_file() {
            true => Err(TrainingError::OnlyWeights(self.best()).into()),
            false => Ok(()),
        }
    }

    /// Locks the folder: two runs may not write into it.
    ///
    /// # Errors
    /// [`aps_data::Error::Locked`] while another one does.
    pub(super) fn lock(&self) -> Result<File> {
        Ok(aps_data::lock_folder(&self.0)?)
    }

    /// The settings of the run.
    pub fn settings(&self) -> PathBuf {
        self.0.join(SETTINGS_FILE)
    }

    /// Everything needed to continue.
    pub fn checkpoint(&self) -> PathBuf {
        self.0.join("last.safetensors")
    }

    /// The weights that did best on the development maps.
    pub fn best(&self) -> PathBuf {
        self.0.join("best.safetensors")
    }

    /// The log of the steps.
    pub fn steps(&self) -> PathBuf {
        self.0.join("steps.csv")
    }

    /// The log of the scores.
    pub fn scores(&self) -> PathBuf {
        self.0.join("scores.csv")
    }

    /// The time spent before each row of the scores.
    pub fn times(&self) -> PathBuf {
        self.0.join("times.csv")
    }

    /// Writes `config.json`.
    pub(super) fn write_settings(&self, settings: &Settings) -> Result<()> {
        let text = serde_json::to_string_pretty(settings)? + "\n";
        Ok(aps_data::replace_file(&self.settings(), text.as_bytes())?)
    }
}

#[cfg(test)]
mod tests {
    use aps_model::ModelKind;
    use aps_model::weights::Shipped;
    use serde_json::json;

    use super::*;

    #[test]
    fn settings_that_no_prediction_can_use_are_refused() {
        let shipped = Shipped::of(ModelKind::MsAreg).unwrap().settings;
        Settings::parse(shipped).unwrap();
        for (at, value, part) in [
            (
                "/training_statistics/std",
                json!(0.0),
                "training_statistics",
            ),
            ("/training_statistics/std", json!(-1), "training_statistics"),
            (
                "/training_statistics/std",
                json!(1e-320),
                "training_statistics",
            ),
            ("/sigma_px", json!(0), "sigma_px"),
            ("/sigma_px", json!(-20), "sigma_px"),
            ("/protocol", json!("mine"), "`mine`"),
        ] {
            let mut settings: Value = serde_json::from_str(shipped).unwrap();
            *settings.pointer_mut(at).unwrap() = value;
            let told = Settings::parse(&settings.to_string()).unwrap_err().chain();
            assert!(told.contains(part), "{told}");
        }
    }
}
