//! Building blocks of the models: one file each. A block gets its tensors from a [`VarBuilder`](candle_nn::VarBuilder) under
//! PyTorch's names, computes with [`crate::ops`], and is a [`Module`](candle_core::Module) or
//! [`ModuleT`](candle_core::ModuleT).

mod batch_norm;
mod conv;
mod dropout;
mod film;
mod linear;
mod mlp;
mod multi_scale;
mod normed_conv;
mod resnet;
mod transformer;
mod unet;

pub(crate) use batch_norm::BatchNorm;
pub(crate) use conv::{Conv1d, Conv2d, ConvTranspose2x2};
pub(crate) use dropout::Dropout;
pub(crate) use film::Film;
pub(crate) use linear::{LayerNorm, Linear};
pub(crate) use mlp::{LEAKY_SLOPE, Mlp};
pub(crate) use multi_scale::MultiScaleEncoder;
pub(crate) use normed_conv::NormedConv;
pub(crate) use resnet::ResNet18;
pub(crate) use transformer::EncoderBlock;
pub(crate) use unet::DoubleConv;
