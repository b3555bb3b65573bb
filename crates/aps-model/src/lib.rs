//! The models of Map2APS in [candle](candle_core): from a city map and two positions to an angle power spectrum.
//!
//! A model is a [`ModuleT`](candle_core::ModuleT), built from a [`VarBuilder`](candle_nn::VarBuilder): from candle's `VarMap`, from
//! a file, or [`seeded`] as in the benchmark. Input of all models but one is a batch of condition images (batch, 3,
//! height, width): buildings, transmitter heatmap, receiver heatmap; [`ModelKind::PolarReg`] takes ways along rays, which another
//! crate finds in the scene. Output is (batch, 180): the normalised spectrum.
//!
//! The main items:
//! - [`ModelKind`] names the eight models of the benchmark and builds them in the sizes of a [`Preset`];
//! - [`Model`] is the trait of all of them, [`Regularizer`] the critic that two of them are trained against;
//! - [`condition`] makes their input of map numbers and coordinates, [`train`] trains them;
//! - [`weights`] reads and writes them, PyTorch's files and pretrained backbones included;
//! - [`onnx`] makes files of them for other runtimes.
//!
//! ```
//! use aps_model::candle_core::{DType, Device, ModuleT, Tensor};
//! use aps_model::candle_nn::VarMap;
//! use aps_model::condition::InputShape;
//! use aps_model::{ModelKind, Preset, seeded};
//!
//! // Tensors of single precision on the CPU, initial values drawn from seed 1.
//! let parameters = VarMap::new();
//! let vb = seeded(&parameters, 1, DType::F32, &Device::Cpu);
//! let model = ModelKind::MsAreg.build(Preset::Small, InputShape::Images, vb)?;
//!
//! let images = Tensor::zeros((2, 3, 64, 64), DType::F32, &Device::Cpu)?;
//! let spectra = model.forward_t(&images, false)?;
//! assert_eq!(spectra.dims(), [2, 180]);
//! # Ok::<(), aps_model::candle_core::Error>(())
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
//! hold them against golden values. Where candle's own operations differ from PyTorch's, the layers have others.
//!
//! # Types
//!
//! Parameters are f32 in use and f64 in tests. Layers compute in the type of their input, so that images in bf16 on a GPU
//! are computed in bf16 with f32 weights, normalisations excepted, which compute in f32: PyTorch's autocast.
#![deny(unsafe_code)]

pub mod condition;
pub mod data;
mod error;
mod kernels;
mod kind;
mod layers;
mod loss;
mod models;
mod named;
pub mod onnx;
mod ops;
pub mod optim;
mod parameters;
mod preset;
mod random;
mod recording;
mod replace;
#[cfg(test)]
mod tests;
pub mod train;
pub mod weights;

pub use candle_core;
pub use candle_nn;
pub use error::{Error, Result};
pub use kind::ModelKind;
pub use loss::Loss;
pub use models::{Model, Regularizer};
pub use parameters::{LabelFacts, frozen, seeded, trainable};
pub use preset::Preset;

/// Angle bins of a spectrum.
pub const ANGLE_BINS: usize = 180;
