//! Max pooling whose gradient goes to one winner: the first of equal ones, row by row, as in PyTorch.

use rayon::prelude::*;

use super::ConvShape;

/// The largest value of each window. `shape` is that of a depthwise sliding window: `in_channels` planes an image.
pub(crate) fn max_pool(shape: &ConvShape, x: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; shape.batch * shape.in_channels * shape.out_pixels()];
    out.par_chunks_mut(shape.out_pixels())
        .zip(x.par_chunks(shape.in_pixels()))
        .with_min_len(8)
        .for_each(|(out, plane)| each_window(shape, plane, |o, at| out[o] = plane[at]));
    out
}

/// The gradient by the input.
pub(crate) fn max_pool_gradient(shape: &ConvShape, x: &[f32], grad: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    out.par_chunks_mut(shape.in_pixels())
        .zip(x.par_chunks(shape.in_pixels()))
        .zip(grad.par_chunks(shape.out_pixels()))
        .with_min_len(8)
        .for_each(|((out, plane), grad)| each_window(shape, plane, |o, at| out[at] += grad[o]));
    out
}

/// Calls back with every window's number and the place of its winner.
fn each_window(shape: &ConvShape, plane: &[f32], mut winner: impl FnMut(usize, usize)) {
    let (step, (kh, kw), (ph, pw)) = (shape.stride, shape.kernel, shape.padding);
    let (oh, ow) = (shape.out_height(), shape.out_width());
    for oy in 0..oh {
        let rows = (oy * step).saturating_sub(ph)..(oy * step + kh - ph).min(shape.height);
        for ox in 0..ow {
            let columns = (ox * step).saturating_sub(pw)..(ox * step + kw - pw).min(shape.width);
            let mut best = rows.start * shape.width + columns.start;
            let mut value = plane[best];
            for y in rows.clone() {
                for x in columns.clone() {
                    let at = y * shape.width + x;
                    // A NaN wins, as in PyTorch: it must not be hidden.
                    if plane[at] > value || plane[at].is_nan() {
                        (best, value) = (at, plane[at]);
                    }
                }
            }
            winner(oy * ow + ox, best);
        }
    }
}
