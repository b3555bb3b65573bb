//! The models and the regularizer: one file each, with its sizes and a [`Spec`] by which [`ModelKind`](crate::ModelKind) knows
//! it.

pub(crate) mod adv_mlp;
pub(crate) mod ms_areg;
pub(crate) mod ms_mlp;
mod noise;
pub(crate) mod radiounet;
mod regularizer;
pub(crate) mod resnet_conv1d;
pub(crate) mod resnet_mlp;
pub(crate) mod vit_reg;

pub use regularizer::Regularizer;

use std::fmt::Debug;

use candle_core::{Device, ModuleT, Result, Tensor, bail};
use candle_nn::VarBuilder;

use crate::condition::{ConditionConfig, ConditionImages, ModelInput, Rasters};
use crate::train::TrainConfig;
use crate::{ANGLE_BINS, Preset};

/// Predictor of spectra: a [`ModuleT`] from its input, of a shape of its own, to (batch, [`ANGLE_BINS`]).
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
    /// True if it is trained against a [`Regularizer`].
    pub is_adversarial: bool,
    /// Builds the model.
    pub build: fn(Preset, VarBuilder<'_>) -> Result<Box<dyn Model>>,
    /// Makes its input.
    pub input: InputFn,
    /// Changes of the paper's settings of training, which differ by `is_adversarial` alone.
    pub settings: fn(TrainConfig) -> TrainConfig,
}

/// Function that makes the input of a model from the maps.
pub(crate) type InputFn =
    fn(Rasters<'_>, ConditionConfig, &Device) -> crate::Result<Box<dyn ModelInput>>;

/// Makes condition images, the input of most models.
fn condition_images(
    rasters: Rasters<'_>,
    config: ConditionConfig,
    device: &Device,
) -> crate::Result<Box<dyn ModelInput>> {
    Ok(Box::new(ConditionImages::new(rasters, config, device)?))
}

/// Channels of a condition image.
const CHANNELS: usize = 3;

/// Returns the number of channels of the first stage of convolutions, to which all other sizes but the spectrum's are
/// proportional.
fn width(preset: Preset) -> usize {
    match preset {
        Preset::Paper => 64,
        Preset::Small => 32,
    }
}

/// Builds the regularizer of an adversarial model.
pub(crate) fn build_regularizer(preset: Preset, vb: VarBuilder<'_>) -> Result<Regularizer> {
    Regularizer::new(width(preset), vb)
}

/// Returns the sizes of the decoder of MS-AReg and its ablations, from `inputs` features.
fn decoder_sizes(inputs: usize, width: usize) -> [usize; 5] {
    [inputs, 16 * width, 16 * width, 8 * width, ANGLE_BINS]
}

fn check_images(images: &Tensor) -> Result<()> {
    match images.dims() {
        &[n, CHANNELS, height, width] if n * height * width > 0 => Ok(()),
        found => {
            bail!("condition images must have the shape [any, {CHANNELS}, any, any], not {found:?}")
        }
    }
}
