//! Models of `aps-model` trained on a data set, and their predictions.
//!
//! [`Training`] says what is trained on what; [`Training::run`] makes all steps and gives the [`Trained`] model. For a step
//! count, logs and closing scores, [`Training::prepare`] gives the [`Run`] itself.
//!
//! ```no_run
#![doc = include_str!("../../examples/train_and_score.rs")]
//! ```
//!
//! # Files of a run
//!
//! - `best.safetensors`: weights that did best on the development maps by [`Selection`], of those scored;
//! - `last.safetensors`: everything needed to continue, after each epoch, each 1000 steps, and when the run is cancelled;
//! - `config.json`: every setting ([`Settings`]);
//! - `steps.csv`: loss, gradient norms and learning rate of each step;
//! - `scores.csv`: mean loss since the row before, and all metrics on the development maps;
//! - `times.csv`: the time spent before each row of `scores.csv`.
//!
//! A run of a number of epochs that is stopped and continued writes the same bytes as one that is not, but for `times.csv`, on a
//! CPU with any number of threads. A run of a time ([`TrainConfig::budget_s`](aps_model::train::TrainConfig::budget_s)) that is
//! continued gets the time that is left; it is scored after fixed shares of its time. Test maps are never looked at.

mod device;
mod error;
mod folder;
mod held_ways;
mod input;
mod link_model;
mod loaded;
mod log;
mod maps;
mod mirror;
mod network;
mod onnx;
mod plan;
mod polar;
mod rows;
mod run;
mod score;
mod selection;
mod trained;

use std::path::Path;

use aps_data::Dataset;
use aps_model::{ANGLE_BINS, Preset};

use crate::error::{At, Place, Result};

pub use crate::control::DevelopmentScores;
pub use device::Device;
pub use error::TrainingError;
pub use folder::{RunFolder, Settings};
pub use link_model::{LinkModel, PredictedLink};
pub use maps::DevelopmentMaps;
pub use network::InitialWeights;
pub use onnx::OnnxModel;
pub use plan::Training;
pub use run::{ClosingScores, Run};
pub use selection::Selection;
pub use trained::Trained;

/// Opens a data set whose labels the models can learn.
///
/// # Errors
/// A data set that cannot be read, stores no angle power spectra, or stores them in other bins than the models predict.
pub fn open(root: &Path) -> Result<Dataset> {
    let dataset = Dataset::open(root)?;
    check(&dataset)?;
    Ok(dataset)
}

fn check(dataset: &Dataset) -> Result<()> {
    match dataset.aps_layout()?.axis.count {
        ANGLE_BINS => Ok(()),
        found => Err(TrainingError::Bins { found }).at_file(Place::Dataset, dataset.root()),
    }
}

/// Returns the image size that a preset is meant for.
pub fn usual_image_size(preset: Preset) -> usize {
    match preset {
        Preset::Paper => 256,
        Preset::Small => 64,
    }
}
