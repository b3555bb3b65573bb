//! The models and the regularizer: one file each, with its sizes and a [`Spec`] by which [`ModelKind`](crate::ModelKind) knows
//! it; MS-AReg's has its ablations too.

mod check;
pub(crate) mod ms_areg;
pub(crate) mod polar_reg;
pub(crate) mod radiounet;
mod regularizer;
pub(crate) mod resnet_conv1d;
pub(crate) mod resnet_mlp;
pub(crate) mod vit_reg;

pub use regularizer::Regularizer;

use std::fmt::Debug;

use candle_core::{ModuleT, Result};
use candle_nn::VarBuilder;

use crate::Preset;
use crate::condition::{InputKind, InputShape};
use crate::loss::Loss;
use crate::train::TrainConfig;

/// Predictor of spectra: a [`ModuleT`] from its input, of a shape of its own, to (batch, [`ANGLE_BINS`](crate::ANGLE_BINS)).
///
/// In training it normalises with the statistics of the batch, moves the running ones, and drops features.
pub trait Model: ModuleT + Debug + Send + Sync {
    /// Sets the features that the next training passes drop to those of a step, so that a training which is continued from
    /// this step drops the same ones. Without this call passes draw one after the other from the same stream in each run.
    fn seed_dropout(&self, seed: u64, step: u64) {
        // Models without dropout draw nothing.
        let _ = (seed, step);
    }
}

/// Facts of a model that hold for all its sizes.
pub(crate) struct Spec {
    /// Name on the command line and in files.
    pub name: &'static str,
    /// Name in tables.
    pub title: &'static str,
    /// Loss that its training minimises.
    pub loss: Loss,
    /// Kind of its input.
    pub input: InputKind,
    /// Builds the model for input of a shape, which must be of the kind.
    pub build: fn(Preset, InputShape, VarBuilder<'_>) -> Result<Box<dyn Model>>,
    /// Changes of the usual settings of training: the paper's, which differ by the loss alone, in smaller steps for a small
    /// preset.
    pub settings: fn(TrainConfig) -> TrainConfig,
}

/// Returns the number of channels of the first stage of convolutions, to which all other sizes but the spectrum's are
/// proportional.
pub(crate) fn width(preset: Preset) -> usize {
    match preset {
        Preset::Paper => 64,
        Preset::Small => 32,
    }
}
