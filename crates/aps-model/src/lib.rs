//! The models of Map2APS in [candle](candle_core): from a city map and two positions to an angle power spectrum.
//!
//! Input of every model is a batch of condition images (batch, 3, height, width): buildings, transmitter heatmap, receiver
//! heatmap. Output is (batch, 180): the normalised spectrum.
//!
//! The main types:
//! - [`ModelKind`] names the seven models of the benchmark and builds them in the sizes of a [`Preset`];
//! - [`Model`] is the trait of all of them: a forward pass in a [`Mode`], and [`Parameters`];
//! - [`Regularizer`] is the critic that two of them are trained against;
//! - [`weights`] reads and writes them, PyTorch's files and pretrained backbones included;
//! - [`condition`] makes their input of map numbers and coordinates, [`train`] teaches them.
//!
//! ```
//! use aps_model::candle_core::{DType, Device, Tensor};
//! use aps_model::{Mode, ModelKind, Parameters, Preset};
//!
//! // Tensors of single precision on the CPU, first values drawn from seed 1.
//! let parameters = Parameters::new(&Device::Cpu, DType::F32, 1);
//! let model = ModelKind::MsAreg.build(Preset::Small, &parameters)?;
//! assert_eq!(model.parameters().count(), 3_789_652);
//!
//! let images = Tensor::zeros((2, 3, 64, 64), DType::F32, &Device::Cpu)?;
//! let spectra = model.forward(&images, Mode::Eval)?;
//! assert_eq!(spectra.dims(), [2, 180]);
//! # Ok::<(), aps_model::Error>(())
//! ```
//!
//! # Features
//!
//! `cuda` and `metal`, both off by default: candle on a GPU. A CPU computes with loops of our own, faster than candle's.
//!
//! # As in PyTorch
//!
//! A tensor has the name, the shape and the distribution of initial values that PyTorch and torchvision give it. Outputs and
//! gradients agree with PyTorch's to rounding, and so do the weights after three optimizer steps in double precision: tests
//! hold them against golden values. Where candle's own operations differ from PyTorch's, [`portable`] has others.
//!
//! # Types
//!
//! Parameters are f32 in use and f64 in tests. Layers compute in the type of their input, so that images in bf16 on a GPU
//! are computed in bf16 with f32 weights, normalisations excepted, which compute in f32: PyTorch's autocast.
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

use std::fmt::Debug;

use candle_core::Tensor;

/// Angle bins of a spectrum.
pub const ANGLE_BINS: usize = 180;

/// Predictor of spectra from condition images.
pub trait Model: Debug + Send + Sync {
    /// Predicts the spectra (batch, [`ANGLE_BINS`]) of condition images (batch, 3, height, width).
    ///
    /// In [`Mode::Train`] batch statistics are used and the running ones moved, and dropout drops.
    fn forward(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor>;

    /// Returns all tensors of the model, by their PyTorch names.
    fn parameters(&self) -> &Parameters;
}
