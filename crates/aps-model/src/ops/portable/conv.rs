//! Convolutions.

use candle_core::{Result, Tensor};

use super::correlation::correlate;
use super::norm::at_least_f32;

/// Windows of images in memory at once [bytes]. In f32 an image takes 0.6 MB in ResNet-18's first stage at 64 px and, the most of
/// all, 302 MB in RadioUNet's last block at 256 px: a GPU holds it, and has enough to do in one part.
const WINDOWS_BYTES: usize = 512 << 20;

/// Cross-correlation of `x` (batch, in, height, width) with `weight` (out, in, kernel height, kernel width), zeros around.
///
/// A one-dimensional convolution is one over images of height 1 with a kernel of height 1. The weight takes the type of `x`, so
/// that half-precision inputs are multiplied in half precision; the bias is added in f32.
pub(crate) fn conv2d(
    x: &Tensor,
    weight: &Tensor,
    bias: Option<&Tensor>,
    stride: usize,
    (pad_h, pad_w): (usize, usize),
) -> Result<Tensor> {
    let weight = weight.to_dtype(x.dtype())?;
    let y = correlate(x, &weight, stride, [pad_h, pad_w], WINDOWS_BYTES)?;
    add_bias(y, bias)
}

/// Transposed convolution with a 2 x 2 kernel and stride 2: every pixel becomes a block of four.
///
/// `x` (batch, in, height, width), `weight` (in, out, 2, 2), `bias` (out). Blocks do not overlap, so that it is one matrix
/// product and a permutation.
pub(crate) fn conv_transpose2x2(x: &Tensor, weight: &Tensor, bias: &Tensor) -> Result<Tensor> {
    let (batch, inputs, height, width) = x.dims4()?;
    let (_, out, _, _) = weight.dims4()?;
    let weight = weight.to_dtype(x.dtype())?.reshape((inputs, out * 4))?;
    let pixels = x.permute((0, 2, 3, 1))?.reshape(((), inputs))?;
    let y = pixels
        .matmul(&weight)?
        .reshape(vec![batch, height, width, out, 2, 2])?
        .permute(vec![0, 3, 1, 4, 2, 5])?
        .reshape((batch, out, 2 * height, 2 * width))?;
    add_bias(y, Some(bias))
}

fn add_bias(y: Tensor, bias: Option<&Tensor>) -> Result<Tensor> {
    match bias {
        None => Ok(y),
        Some(bias) => {
            // Its gradient is a sum over the pixels of a batch.
            let wide = at_least_f32(&y)?;
            let bias = bias.to_dtype(wide.dtype())?.reshape((1, (), 1, 1))?;
            wide.broadcast_add(&bias)?.to_dtype(y.dtype())
        }
    }
}
