//! The gradient of a convolution by its weights.

use rayon::prelude::*;

use super::ConvShape;
use super::convolution::framed_images;
use super::matmul::{Matrix, multiply};
use super::regroup::side_by_side;
use super::unfold::Frame;
use super::winograd;

/// Rows of the unfolded input of one task.
const TAP_BLOCK: usize = 192;
/// Pixels taken at once: enough to fill the product, few enough for the tile to stay in cache.
const PIXELS: usize = 256;
/// Values from row to row of a tile: not a power of two, so that rows do not fall on the same cache lines.
const STRIDE: usize = PIXELS + 16;
/// Fewest tasks wanted.
const TASKS: usize = 8;

/// The gradient (out, in, kh, kw) from the input `x` (batch, in, height, width) and `grad` (batch, out, oh, ow).
///
/// A task is some rows of the unfolded input over some of the pixels; parts over different pixels are added in order.
pub(crate) fn weight_gradient(shape: &ConvShape, x: &[f32], grad: &[f32]) -> Vec<f32> {
    assert_eq!(x.len(), shape.input_len());
    assert_eq!(grad.len(), shape.output_len());
    let mut out = vec![0.0; shape.weight_len()];
    if let Some(size) = winograd::suits(shape, false) {
        winograd::weight_gradient(size, shape, x, grad, &mut out);
        return out;
    }
    let (taps, outs) = (shape.taps(), shape.out_channels);
    let all = shape.batch * shape.out_pixels();
    let (rows, apart_by) = side_by_side(grad, outs, shape.out_pixels());
    let frame = Frame::of(shape);
    let framed = framed_images(shape, &frame, x);

    let blocks = taps.div_ceil(TAP_BLOCK);
    let tiles = all.div_ceil(PIXELS);
    let parts = TASKS.div_ceil(blocks).min(tiles);
    let pixels_a_part = tiles.div_ceil(parts) * PIXELS;
    let task = |i: usize| {
        let (block, part) = (i / parts, i % parts);
        let taps = block * TAP_BLOCK..taps.min((block + 1) * TAP_BLOCK);
        let pixels = part * pixels_a_part..all.min((part + 1) * pixels_a_part);
        let mut made = vec![0.0; outs * taps.len()];
        let mut columns = vec![0.0; taps.len() * STRIDE];
        for first in pixels.clone().step_by(PIXELS) {
            let count = PIXELS.min(pixels.end - first);
            let range = first..first + count;
            frame.unfold(&framed, taps.clone(), range, &mut columns, STRIDE);
            let a = Matrix::rows(&columns, STRIDE);
            let b = Matrix::columns(&rows[first..], apart_by);
            let sizes = (taps.len(), outs, count);
            multiply(sizes, a, b, &mut made, taps.len(), first > pixels.start);
        }
        made
    };
    let made: Vec<Vec<f32>> = (0..blocks * parts).into_par_iter().map(task).collect();
    out.par_chunks_mut(taps).enumerate().for_each(|(o, row)| {
        for (target, parts) in row.chunks_mut(TAP_BLOCK).zip(made.chunks_exact(parts)) {
            let count = target.len();
            target.copy_from_slice(&parts[0][o * count..][..count]);
            for part in &parts[1..] {
                for (t, p) in target.iter_mut().zip(&part[o * count..][..count]) {
                    *t += p;
                }
            }
        }
    });
    out
}
