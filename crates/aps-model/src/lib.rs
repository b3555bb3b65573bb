//! The models of Map2APS in [candle](candle_core): from a city map and two positions to an angle power spectrum.
//!
//! Input of every model is a batch of condition images (batch, 3, height, width): buildings, transmitter heatmap, receiver
//! heatmap. Output is (batch, 180): the normalised spectrum.
#![deny(unsafe_code)]

pub mod condition;
pub mod data;
mod error;
mod init;
mod kernels;
mod kind;
pub mod layers;
pub mod loss;
mod mode;
pub mod models;
pub mod ops;
pub mod optim;
mod parameters;
pub mod portable;
pub mod train;
pub mod weights;

pub use candle_core;
pub use error::{Error, Result};
pub use init::Init;
pub use kind::{ModelKind, Preset};
pub use mode::Mode;
pub use models::Regularizer;
pub use parameters::{Kind, Parameter, Parameters, Scope};

use candle_core::Tensor;

/// Angle bins of a spectrum.
pub const ANGLE_BINS: usize = 180;

/// What every predictor of spectra is.
pub trait Model: Send + Sync {
    /// Spectra (batch, [`ANGLE_BINS`]) of condition images (batch, 3, height, width).
    ///
    /// In [`Mode::Train`] batch statistics are used and the running ones moved, and dropout drops.
    fn forward(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor>;

    /// All tensors of the model, by their PyTorch names.
    fn parameters(&self) -> &Parameters;
}
