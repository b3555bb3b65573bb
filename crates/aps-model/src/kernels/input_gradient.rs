//! The gradient of a convolution by its input, which is also the transposed convolution.

use rayon::prelude::*;

use super::ConvShape;
use super::convolution::{convolve, tile_pixels};
use super::epilogue::Epilogue;
use super::matmul::{Matrix, multiply};
use super::regroup::{apart, side_by_side};
use super::unfold::Frame;

/// Input channels of one task.
const CHANNEL_BLOCK: usize = 16;

/// The gradient (batch, in, height, width) from `grad` (batch, out, oh, ow) and `weight` (out, in, kh, kw).
pub(crate) fn input_gradient(shape: &ConvShape, grad: &[f32], weight: &[f32]) -> Vec<f32> {
    assert_eq!(grad.len(), shape.output_len());
    assert_eq!(weight.len(), shape.weight_len());
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
        let weight = turn(shape, weight);
        convolve(&flipped, grad, &weight, None, Epilogue::default())
    } else {
        fold_together(shape, grad, weight)
    }
}

/// Weights (out, in, kh, kw) as (in, out, kh, kw) with the kernel turned by 180 degrees.
fn turn(shape: &ConvShape, weight: &[f32]) -> Vec<f32> {
    let taps = shape.kernel.0 * shape.kernel.1;
    let mut out = vec![0.0; weight.len()];
    // Some input channels at a time, which are neighbours in memory.
    out.par_chunks_mut(CHANNEL_BLOCK * shape.out_channels * taps)
        .enumerate()
        .for_each(|(block, rows)| {
            for o in 0..shape.out_channels {
                let first = o * shape.in_channels + block * CHANNEL_BLOCK;
                let sources = weight[first * taps..].chunks_exact(taps);
                let targets = rows.chunks_exact_mut(shape.out_channels * taps);
                for (row, source) in targets.zip(sources) {
                    let target = &mut row[o * taps..][..taps];
                    target.copy_from_slice(source);
                    target.reverse();
                }
            }
        });
    out
}

/// Gradients of the unfolded input, a few channels at a time, folded back where they came from.
fn fold_together(shape: &ConvShape, grad: &[f32], weight: &[f32]) -> Vec<f32> {
    let (out_pixels, in_pixels) = (shape.out_pixels(), shape.in_pixels());
    let (rows, apart_by) = side_by_side(grad, shape.out_channels, out_pixels);
    let taps_a_channel = shape.kernel.0 * shape.kernel.1;
    let all = shape.batch * out_pixels;
    let images = (tile_pixels(CHANNEL_BLOCK * taps_a_channel, all) / out_pixels).max(1);
    let mut planes = vec![0.0; shape.input_len()];
    planes
        .par_chunks_mut(CHANNEL_BLOCK * shape.batch * in_pixels)
        .enumerate()
        .for_each_init(Scratch::default, |scratch, (block, planes)| {
            let part = ConvShape {
                in_channels: planes.len() / (shape.batch * in_pixels),
                ..*shape
            };
            let (frame, taps) = (Frame::of(&part), part.taps());
            for first in (0..shape.batch).step_by(images) {
                let here = images.min(shape.batch - first);
                let count = here * out_pixels;
                scratch.columns.resize(taps * count, 0.0);
                let a = Matrix::columns(&rows[first * out_pixels..], apart_by);
                let weight = &weight[block * CHANNEL_BLOCK * taps_a_channel..];
                let b = Matrix::rows(weight, shape.taps());
                let sizes = (count, taps, shape.out_channels);
                multiply(sizes, a, b, &mut scratch.columns, count, false);
                scratch.framed.clear();
                scratch.framed.resize(here * frame.len(), 0.0);
                frame.fold(&scratch.columns, count, &mut scratch.framed);
                scratch.image.resize(part.in_channels * in_pixels, 0.0);
                for (n, framed) in scratch.framed.chunks_exact(frame.len()).enumerate() {
                    frame.extract(framed, &mut scratch.image);
                    for (c, pixels) in scratch.image.chunks_exact(in_pixels).enumerate() {
                        let start = (c * shape.batch + first + n) * in_pixels;
                        planes[start..start + in_pixels].copy_from_slice(pixels);
                    }
                }
            }
        });
    let mut out = vec![0.0; shape.input_len()];
    apart(&planes, shape.in_channels, in_pixels, &mut out);
    out
}

/// Buffers that a thread keeps from block to block.
#[derive(Default)]
struct Scratch {
    columns: Vec<f32>,
    framed: Vec<f32>,
    image: Vec<f32>,
}
