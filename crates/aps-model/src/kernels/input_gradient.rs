//! The gradient of a convolution by its input, which is also the transposed convolution.

use rayon::prelude::*;

use super::ConvShape;
use super::convolution::{convolve, tile_pixels};
use super::matmul::{Matrix, multiply};
use super::regroup::{apart, side_by_side};
use super::unfold::fold_row;

/// Input channels of one task.
const CHANNEL_BLOCK: usize = 16;

/// `out` (batch, in, height, width) from `grad` (batch, out, oh, ow) and `weight` (out, in, kh, kw).
pub(crate) fn input_gradient(shape: &ConvShape, grad: &[f32], weight: &[f32], out: &mut [f32]) {
    assert_eq!(grad.len(), shape.output_len());
    assert_eq!(weight.len(), shape.weight_len());
    assert_eq!(out.len(), shape.input_len());
    let (kh, kw) = shape.kernel;
    if shape.stride == 1 && shape.padding.0 < kh && shape.padding.1 < kw {
        let flipped = ConvShape {
            in_channels: shape.out_channels,
            out_channels: shape.in_channels,
            height: shape.out_height(),
            width: shape.out_width(),
            padding: (kh - 1 - shape.padding.0, kw - 1 - shape.padding.1),
            ..*shape
        };
        convolve(&flipped, grad, &turn(shape, weight), None, out);
    } else {
        fold_together(shape, grad, weight, out);
    }
}

/// Weights (out, in, kh, kw) as (in, out, kh, kw) with the kernel turned by 180 degrees.
fn turn(shape: &ConvShape, weight: &[f32]) -> Vec<f32> {
    let taps = shape.kernel.0 * shape.kernel.1;
    let mut out = vec![0.0; weight.len()];
    out.par_chunks_mut(shape.out_channels * taps)
        .enumerate()
        .for_each(|(i, row)| {
            for (o, target) in row.chunks_exact_mut(taps).enumerate() {
                let source = &weight[(o * shape.in_channels + i) * taps..][..taps];
                for (t, s) in target.iter_mut().zip(source.iter().rev()) {
                    *t = *s;
                }
            }
        });
    out
}

/// Gradients of the unfolded input, a few channels at a time, folded back where they came from.
fn fold_together(shape: &ConvShape, grad: &[f32], weight: &[f32], out: &mut [f32]) {
    let (kh, kw) = shape.kernel;
    let (out_pixels, in_pixels) = (shape.out_pixels(), shape.in_pixels());
    let (rows, apart_by) = side_by_side(grad, shape.out_channels, out_pixels);
    let all = shape.batch * out_pixels;
    let mut planes = vec![0.0; shape.input_len()];
    let images = (tile_pixels(CHANNEL_BLOCK * kh * kw, all) / out_pixels).max(1);
    planes
        .par_chunks_mut(CHANNEL_BLOCK * shape.batch * in_pixels)
        .enumerate()
        .for_each_init(Vec::new, |columns: &mut Vec<f32>, (block, planes)| {
            let first_tap = block * CHANNEL_BLOCK * kh * kw;
            let taps = planes.len() / (shape.batch * in_pixels) * kh * kw;
            for first in (0..shape.batch).step_by(images) {
                let here = images.min(shape.batch - first);
                let count = here * out_pixels;
                columns.resize(taps * count, 0.0);
                let a = Matrix {
                    data: &rows[first * out_pixels..],
                    row_stride: 1,
                    col_stride: apart_by,
                };
                let b = Matrix {
                    data: &weight[first_tap..],
                    row_stride: shape.taps(),
                    col_stride: 1,
                };
                multiply(
                    (count, taps, shape.out_channels),
                    a,
                    b,
                    columns,
                    count,
                    false,
                );
                for (tap, line) in columns.chunks_exact(count).enumerate() {
                    let (channel, ky, kx) = (tap / (kh * kw), tap / kw % kh, tap % kw);
                    for (n, line) in line.chunks_exact(out_pixels).enumerate() {
                        let plane = (channel * shape.batch + first + n) * in_pixels;
                        fold_row(shape, line, (ky, kx), &mut planes[plane..][..in_pixels]);
                    }
                }
            }
        });
    apart(&planes, shape.in_channels, in_pixels, out);
}
