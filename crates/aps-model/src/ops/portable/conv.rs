//! Convolutions.

use candle_core::{Result, Tensor};

use crate::kernels::Steps;

/// Cross-correlation of `x` (batch, in, height, width) with `weight` (out, in, kernel height, kernel width).
///
/// A one-dimensional convolution is one over images of height 1 with a kernel of height 1. Weight and bias take the type
/// of `x`, so that half-precision inputs are computed in half precision.
pub(crate) fn conv2d(
    x: &Tensor,
    weight: &Tensor,
    bias: Option<&Tensor>,
    steps: Steps,
) -> Result<Tensor> {
    let weight = weight.to_dtype(x.dtype())?;
    let ((pad_h, pad_w), (stride_h, stride_w)) = (steps.padding, steps.stride);
    let y = if steps.is_dense() && pad_h == pad_w {
        x.conv2d(&weight, pad_h, 1, 1, 1)?
    } else {
        let (_, _, kernel_h, kernel_w) = weight.dims4()?;
        // candle knows one padding for both directions, and in its gradient one remainder of the stride for both.
        let x = pad_and_trim(x, 2, pad_h, kernel_h, stride_h)?;
        let x = match steps.is_circular {
            true => pad_and_trim(&wrapped(&x, pad_w)?, 3, 0, kernel_w, stride_w)?,
            false => pad_and_trim(&x, 3, pad_w, kernel_w, stride_w)?,
        };
        match stride_h == stride_w {
            true => x.conv2d(&weight, 0, stride_w, 1, 1)?,
            false => {
                let y = by_rows(&x, &weight, stride_h)?.conv2d(&flat(&weight)?, 0, 1, 1, 1)?;
                let columns = (0..y.dim(3)? as u32).step_by(stride_w);
                y.index_select(&Tensor::from_iter(columns, y.device())?, 3)?
            }
        }
    };
    add_bias(y, bias)
}

/// Puts the other end of each row, so many values, to its left and right.
pub(crate) fn wrapped(x: &Tensor, pad: usize) -> Result<Tensor> {
    let dim = x.rank() - 1;
    let width = x.dim(dim)?;
    let (left, right) = (x.narrow(dim, width - pad, pad)?, x.narrow(dim, 0, pad)?);
    Tensor::cat(&[&left, x, &right], dim)
}

/// Makes channels of the rows of `x` that a kernel of this weight sees at once: (batch, kernel height * in, height', width).
fn by_rows(x: &Tensor, weight: &Tensor, stride: usize) -> Result<Tensor> {
    let kernel = weight.dim(2)?;
    let count = (x.dim(2)?.saturating_sub(kernel) / stride + 1) as u32;
    let rows = |ky: usize| {
        let rows = (0..count).map(|row| row * stride as u32 + ky as u32);
        x.index_select(&Tensor::from_iter(rows, x.device())?, 2)
    };
    Tensor::cat(&(0..kernel).map(rows).collect::<Result<Vec<_>>>()?, 1)
}

/// The kernels of a weight for the channels of [`by_rows`].
fn flat(weight: &Tensor) -> Result<Tensor> {
    let (out, inputs, kernel_h, kernel_w) = weight.dims4()?;
    let weight = weight.transpose(1, 2)?.contiguous()?;
    weight.reshape((out, kernel_h * inputs, 1, kernel_w))
}

/// Cross-correlation of each channel of `x` (batch, channels, length) with a kernel of its own, `weight` (channels, 1, odd), the
/// taps `dilation` apart, circular: it keeps the length.
pub(crate) fn depthwise(x: &Tensor, weight: &Tensor, dilation: usize) -> Result<Tensor> {
    let weight = weight.to_dtype(x.dtype())?;
    let (taps, length) = (weight.dim(2)?, x.dim(2)?);
    let padded = wrapped(x, taps / 2 * dilation)?;
    let tap = |t: usize| {
        let factor = weight.narrow(2, t, 1)?.transpose(0, 1)?;
        padded
            .narrow(2, t * dilation, length)?
            .broadcast_mul(&factor)
    };
    let mut sum = tap(0)?;
    for t in 1..taps {
        sum = (sum + tap(t)?)?;
    }
    Ok(sum)
}

/// Pads a dimension with zeros and cuts the end that no window reaches.
fn pad_and_trim(
    x: &Tensor,
    dim: usize,
    pad: usize,
    kernel: usize,
    stride: usize,
) -> Result<Tensor> {
    let size = x.dim(dim)? + 2 * pad;
    let unused = size.checked_sub(kernel).map_or(0, |room| room % stride);
    let cut = unused.saturating_sub(pad);
    let x = x.narrow(dim, 0, x.dim(dim)? - cut)?;
    x.pad_with_zeros(dim, pad, pad - unused.min(pad))
}

/// Transposed convolution with a 2 x 2 kernel and stride 2: every pixel becomes a block of four.
///
/// `x` (batch, in, height, width), `weight` (in, out, 2, 2), `bias` (out). Blocks do not overlap, so that it is one matrix
/// product and a permutation.
pub(crate) fn conv_transpose2x2(x: &Tensor, weight: &Tensor, bias: &Tensor) -> Result<Tensor> {
    let (batch, inputs, height, width) = x.dims4()?;
    let (_, out, _, _) = weight.dims4()?;
    let weight = weight
        .to_dtype(x.dtype())?
        .reshape((inputs, out * 4))?
        .t()?;
    let pixels = x.contiguous()?.reshape((batch, inputs, height * width))?;
    let blocks = weight.broadcast_matmul(&pixels)?;
    let y = blocks
        .reshape(vec![batch, out, 2, 2, height, width])?
        .permute(vec![0, 1, 4, 2, 5, 3])?
        .reshape((batch, out, 2 * height, 2 * width))?;
    add_bias(y, Some(bias))
}

fn add_bias(y: Tensor, bias: Option<&Tensor>) -> Result<Tensor> {
    match bias {
        None => Ok(y),
        Some(bias) => {
            let bias = bias.to_dtype(y.dtype())?.reshape((1, (), 1, 1))?;
            y.broadcast_add(&bias)
        }
    }
}
