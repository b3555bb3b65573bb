//! Changes of resolution.

use candle_core::{Result, Tensor};

use super::constants::matrix;

/// Bilinear resizing of (batch, channels, height, width) to `height` x `width`, pixels being areas: PyTorch's
/// `interpolate(mode="bilinear", align_corners=False)`, without smoothing when it shrinks.
///
/// It is computed as two products with constant matrices.
pub(crate) fn resize_bilinear(x: &Tensor, height: usize, width: usize) -> Result<Tensor> {
    let (batch, channels, old_height, old_width) = x.dims4()?;
    if (old_height, old_width) == (height, width) {
        return Ok(x.clone());
    }
    let weights = |old: usize, new: usize| {
        let make = || (interpolation(old, new), (old, new));
        matrix(("interpolation", [old, new, 0]), x, make)
    };
    let (columns, rows) = (weights(old_width, width)?, weights(old_height, height)?);
    let wide = x
        .contiguous()?
        .reshape((batch * channels * old_height, old_width))?
        .matmul(&columns)?
        .reshape((batch * channels, old_height, width))?;
    let turned = wide
        .transpose(1, 2)?
        .contiguous()?
        .reshape((batch * channels * width, old_height))?
        .matmul(&rows)?
        .reshape((batch, channels, width, height))?;
    turned.transpose(2, 3)?.contiguous()
}

/// Matrix (old, new) whose column holds the weights of the old pixels in a new one.
pub(crate) fn interpolation(old: usize, new: usize) -> Vec<f64> {
    let mut weights = vec![0.0_f64; old * new];
    let step = old as f64 / new as f64;
    for j in 0..new {
        // Centre of the new pixel on the old axis; what lies before the first centre takes the first pixel.
        let position = (step * (j as f64 + 0.5) - 0.5).max(0.0);
        let low = (position as usize).min(old - 1);
        let high = (low + 1).min(old - 1);
        let part = position - low as f64;
        weights[low * new + j] += 1.0 - part;
        weights[high * new + j] += part;
    }
    weights
}

/// Every element of the last dimension twice.
pub(crate) fn upsample_nearest_2x(x: &Tensor) -> Result<Tensor> {
    let mut dims = x.dims().to_vec();
    let rank = dims.len();
    dims.push(2);
    let pairs = x.unsqueeze(rank)?.broadcast_as(dims.as_slice())?;
    dims.pop();
    if let Some(last) = dims.last_mut() {
        *last *= 2;
    }
    pairs.reshape(dims)
}
