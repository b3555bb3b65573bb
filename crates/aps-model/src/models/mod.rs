//! The seven models and the regularizer: one file each, with its sizes.

mod adv_mlp;
mod ms_areg;
mod ms_mlp;
mod noise;
mod radiounet;
mod regularizer;
mod resnet_conv1d;
mod resnet_mlp;
mod vit_reg;

pub use adv_mlp::AdvMlp;
pub use ms_areg::MsAreg;
pub use ms_mlp::MsMlp;
pub use radiounet::RadioUnet;
pub use regularizer::Regularizer;
pub use resnet_conv1d::ResnetConv1d;
pub use resnet_mlp::ResnetMlp;
pub use vit_reg::{VitReg, VitRegConfig};

use crate::error::check_shape;
use crate::{ANGLE_BINS, Result};

/// Channels of a condition image.
const CHANNELS: usize = 3;

/// Sizes of the decoder of MS-AReg and its ablations, from `inputs` features.
fn decoder_sizes(inputs: usize, width: usize) -> [usize; 5] {
    [inputs, 16 * width, 16 * width, 8 * width, ANGLE_BINS]
}

fn check_images(images: &candle_core::Tensor) -> Result<()> {
    check_shape("condition images", images, &[0, CHANNELS, 0, 0])
}
