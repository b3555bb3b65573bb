//! Building blocks of the models: one file each. A block asks a [`Scope`](crate::Scope) for its tensors under PyTorch's
//! names and computes with [`crate::ops`].

mod batch_norm;
mod conv;
mod film;
mod layer_norm;
mod linear;
mod mlp;
mod multi_scale;
mod normed_conv;
mod resnet;
mod transformer;
mod unet;

pub use batch_norm::BatchNorm;
pub use conv::{Conv1d, Conv2d, ConvTranspose2x2};
pub use film::Film;
pub use layer_norm::LayerNorm;
pub use linear::Linear;
pub use mlp::{LEAKY_SLOPE, Mlp};
pub use multi_scale::{MultiScale, MultiScaleEncoder};
pub use normed_conv::NormedConv;
pub use resnet::{ResNet18, Stage};
pub use transformer::{EncoderBlock, SelfAttention};
pub use unet::DoubleConv;
