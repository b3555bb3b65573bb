//! Forward pass of a convolution.

use rayon::prelude::*;

use super::ConvShape;
use super::buffer::Buffer;
use super::epilogue::Epilogue;
use super::matmul::{Matrix, multiply};
use super::regroup::apart;
use super::unfold::Frame;
use super::winograd::{self, KernelCache};

/// Most values of an unfolded tile: 1 MB, so that it stays in a core's second-level cache.
const TILE_VALUES: usize = 1 << 18;
/// Most values unfolded at once where all threads share them.
const SHARED_VALUES: usize = 1 << 22;

/// `x` (batch, in, height, width) convolved with `weight` (out, in, kh, kw), and finished: (batch, out, oh, ow). `cache` keeps
/// the transformed kernels of a weight that never changes.
pub(crate) fn convolve(
    shape: &ConvShape,
    x: &[f32],
    weight: &[f32],
    cache: Option<&KernelCache>,
    epilogue: Epilogue<'_>,
) -> Vec<f32> {
    assert_eq!(x.len(), shape.input_len());
    assert_eq!(weight.len(), shape.weight_len());
    let mut out = vec![0.0; shape.output_len()];
    if let Some(size) = winograd::suits(shape, cache.is_some()) {
        winograd::convolve(size, shape, x, weight, cache, epilogue, &mut out);
    } else if shape.is_by_image() {
        by_image(shape, x, weight, epilogue, &mut out);
    } else {
        together(shape, x, weight, epilogue, &mut out);
    }
    out
}

/// Pixels of a tile: what fits, in whole vectors.
pub(super) fn tile_pixels(taps: usize, pixels: usize) -> usize {
    // The product works on 64 columns at a time.
    let fits = (TILE_VALUES / taps / 64 * 64).clamp(64, 512);
    // Equal tiles rather than a small last one.
    let tiles = pixels.div_ceil(fits);
    pixels.div_ceil(tiles).next_multiple_of(64).min(pixels)
}

/// Convolves each image in one thread, tile by tile.
fn by_image(shape: &ConvShape, x: &[f32], weight: &[f32], epilogue: Epilogue<'_>, out: &mut [f32]) {
    let (taps, pixels) = (shape.taps(), shape.out_pixels());
    let tile = tile_pixels(taps, pixels);
    let frame = Frame::of(shape);
    x.par_chunks(shape.in_channels * shape.in_pixels())
        .zip(out.par_chunks_mut(shape.out_channels * pixels))
        .enumerate()
        .for_each_init(Scratch::default, |scratch, (number, (image, out))| {
            if !shape.is_pointwise() {
                scratch.framed.resize(frame.len(), 0.0);
                scratch.columns.resize(taps * tile, 0.0);
                frame.fill(image, &mut scratch.framed);
            }
            for first in (0..pixels).step_by(tile) {
                let count = tile.min(pixels - first);
                let a = if shape.is_pointwise() {
                    Matrix::columns(&image[first..], pixels)
                } else {
                    let range = first..first + count;
                    frame.unfold(&scratch.framed, 0..taps, range, &mut scratch.columns, tile);
                    Matrix::columns(&scratch.columns, tile)
                };
                let sizes = (count, shape.out_channels, taps);
                let weight = Matrix::columns(weight, taps);
                multiply(sizes, a, weight, &mut out[first..], pixels, false);
            }
            for (channel, plane) in out.chunks_exact_mut(pixels).enumerate() {
                let place = (number * shape.out_channels + channel) * pixels;
                epilogue.apply(channel, place, plane);
            }
        });
}

/// Buffers that a thread keeps from image to image.
#[derive(Default)]
struct Scratch {
    framed: Vec<f32>,
    columns: Vec<f32>,
}

/// Convolves all images side by side: all threads unfold them, once, and each computes some of the output channels.
fn together(shape: &ConvShape, x: &[f32], weight: &[f32], epilogue: Epilogue<'_>, out: &mut [f32]) {
    let (taps, pixels, batch) = (shape.taps(), shape.out_pixels(), shape.batch);
    let mut planes = Buffer::of(shape.output_len());
    let all = batch * pixels;
    let step = (SHARED_VALUES / taps).clamp(1, all);
    let mut columns = Buffer::of(taps * step);
    let frame = Frame::of(shape);
    let framed = framed_images(shape, &frame, x);
    // Columns that do not stay in cache are read as seldom as sharing the work allows.
    let channel_block = if taps * step > TILE_VALUES { 128 } else { 64 };
    for first in (0..all).step_by(step) {
        let count = step.min(all - first);
        unfold_together(shape, &frame, &framed, first, count, &mut columns, step);
        planes
            .par_chunks_mut(channel_block * all)
            .enumerate()
            .for_each(|(block, planes)| {
                let c = block * channel_block;
                let channels = planes.len() / all;
                let a = Matrix::columns(&columns, step);
                let weight = Matrix::columns(&weight[c * taps..], taps);
                let sizes = (count, channels, taps);
                multiply(sizes, a, weight, &mut planes[first..], all, false);
            });
    }
    apart(&planes, shape.out_channels, pixels, out);
    out.par_chunks_mut(pixels)
        .with_min_len(64)
        .enumerate()
        .for_each(|(place, plane)| {
            epilogue.apply(place % shape.out_channels, place * pixels, plane);
        });
}

/// Returns all images, each in its frame.
pub(super) fn framed_images(shape: &ConvShape, frame: &Frame, x: &[f32]) -> Vec<f32> {
    let mut framed = vec![0.0; shape.batch * frame.len()];
    framed
        .par_chunks_mut(frame.len())
        .zip(x.par_chunks(shape.in_channels * shape.in_pixels()))
        .for_each(|(framed, image)| frame.fill(image, framed));
    framed
}

/// Columns `first..first + count` of the unfolded images side by side.
fn unfold_together(
    shape: &ConvShape,
    frame: &Frame,
    framed: &[f32],
    first: usize,
    count: usize,
    columns: &mut [f32],
    stride: usize,
) {
    columns
        .par_chunks_mut(stride * TAPS_AT_ONCE)
        .enumerate()
        .for_each(|(i, columns)| {
            let taps = i * TAPS_AT_ONCE..shape.taps().min((i + 1) * TAPS_AT_ONCE);
            frame.unfold(framed, taps, first..first + count, columns, stride);
        });
}

/// Rows of the unfolded input that a thread makes at once.
const TAPS_AT_ONCE: usize = 64;
