//! The shape of condition images, which models of images and the regularizer check.

use candle_core::{Result, Tensor, bail};

/// Channels of a condition image.
pub(super) const CHANNELS: usize = 3;

/// Refuses tensors that are no batch of condition images.
pub(super) fn check_images(images: &Tensor) -> Result<()> {
    match images.dims() {
        &[n, CHANNELS, height, width] if n * height * width > 0 => Ok(()),
        found => {
            bail!("condition images must have the shape [any, {CHANNELS}, any, any], not {found:?}")
        }
    }
}
