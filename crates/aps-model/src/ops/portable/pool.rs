//! Pooling.

use candle_core::{Result, Tensor};

use super::constants::matrix;
use super::norm::at_least_f32;

/// Maximum of 2 x 2 blocks; an odd last row or column is left out, as in PyTorch.
///
/// The gradient goes to one element of each block: of equal ones the first in the order of rows, then of columns.
pub(crate) fn max_pool_2x2(x: &Tensor) -> Result<Tensor> {
    let pairs = |x: &Tensor, dim| {
        let half = x.dim(dim)? / 2;
        let even = every_other(x, dim, 0, half)?;
        first_larger(&even, &every_other(x, dim, 1, half)?)
    };
    pairs(&pairs(x, 3)?, 2)
}

/// Maximum of windows of 3 x 3, two apart, with one row and column of padding: the one of ResNet's stem.
///
/// The gradient goes to one element of each window: of equal ones the first in the order of rows, then of columns.
pub(crate) fn max_pool_3x3_s2_p1(x: &Tensor) -> Result<Tensor> {
    let triples = |x: &Tensor, dim| {
        let size = x.dim(dim)?;
        let out = size.div_ceil(2);
        let infinity = |count| {
            let mut dims = x.dims().to_vec();
            dims[dim] = count;
            Tensor::full(f32::NEG_INFINITY, dims, x.device())?.to_dtype(x.dtype())
        };
        // To 2 out + 2 rows, so that all three selections below are halves of an even number.
        let padded = Tensor::cat(&[&infinity(1)?, x, &infinity(2 * out + 1 - size)?], dim)?;
        // Windows start at padded rows 0, 2, 4, ...
        let first = every_other(&padded, dim, 0, out)?;
        let second = every_other(&padded, dim, 1, out)?;
        let third = every_other(&padded, dim, 2, out)?;
        first_larger(&first_larger(&first, &second)?, &third)
    };
    triples(&triples(x, 3)?, 2)
}

/// Elements start, start + 2, ... of a dimension, `count` of them.
fn every_other(x: &Tensor, dim: usize, start: usize, count: usize) -> Result<Tensor> {
    let (skipped, parity) = (start / 2 * 2, start % 2);
    let mut dims = x.dims().to_vec();
    dims[dim] = count;
    dims.insert(dim + 1, 2);
    let pairs = x.narrow(dim, skipped, 2 * count)?.reshape(dims)?;
    pairs.narrow(dim + 1, parity, 1)?.squeeze(dim + 1)
}

/// The larger of two, the first of equal ones, with the gradient to that one alone. NaN is larger than all, as in PyTorch.
fn first_larger(first: &Tensor, second: &Tensor) -> Result<Tensor> {
    let is_second = (second.gt(first)? + second.ne(second)?)?;
    is_second.where_cond(second, first)
}

/// Mean over `out` x `out` parts of an image: part i reaches from floor(i n / out) to ceil((i + 1) n / out), as in PyTorch.
///
/// Parts overlap where `out` does not divide the size, and repeat where it is larger. A product with a constant matrix.
pub(crate) fn adaptive_avg_pool(x: &Tensor, out: usize) -> Result<Tensor> {
    let (batch, channels, height, width) = x.dims4()?;
    if out == 1 {
        return at_least_f32(x)?.mean_keepdim((2, 3))?.to_dtype(x.dtype());
    }
    let weights = matrix(("means", [height, width, out]), x, || {
        (averages([height, width], out), (height * width, out * out))
    })?;
    let pixels = x
        .contiguous()?
        .reshape((batch * channels, height * width))?;
    pixels
        .matmul(&weights)?
        .reshape((batch, channels, out, out))
}

/// Shares of the pixels of an image in the means of [`adaptive_avg_pool`]: (pixels, parts).
pub(crate) fn averages([height, width]: [usize; 2], out: usize) -> Vec<f64> {
    let (rows, columns) = (shares(height, out), shares(width, out));
    let mut weights = Vec::with_capacity(height * width * out * out);
    for y in 0..height {
        for x in 0..width {
            for i in 0..out {
                weights.extend((0..out).map(|j| rows[i * height + y] * columns[j * width + x]));
            }
        }
    }
    weights
}

/// Row i holds the share of each of `size` elements in the mean of part i of `out`.
fn shares(size: usize, out: usize) -> Vec<f64> {
    let mut shares = vec![0.0; out * size];
    for (i, row) in shares.chunks_mut(size).enumerate() {
        let part = i * size / out..((i + 1) * size).div_ceil(out);
        let share = 1.0 / part.len() as f64;
        row[part].fill(share);
    }
    shares
}
