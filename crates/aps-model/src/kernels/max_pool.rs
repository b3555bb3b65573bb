//! Max pooling whose gradient goes to one winner: the first of equal ones, row by row, as in PyTorch.

use std::ops::Range;

use multiversion::multiversion;
use rayon::prelude::*;

use super::ConvShape;

/// Pixels from one window to the next: a number that the compiler knows.
pub(crate) const STEP: usize = 2;

/// Returns the largest value of each window. `shape` is that of a depthwise sliding window with stride [`STEP`]: `in_channels`
/// planes an image.
pub(crate) fn max_pool(shape: &ConvShape, x: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; shape.batch * shape.in_channels * shape.out_pixels()];
    out.par_chunks_mut(shape.out_pixels())
        .zip(x.par_chunks(shape.in_pixels()))
        .with_min_len(8)
        .for_each_init(Vec::new, |columns, (out, plane)| {
            largest(shape, plane, out, columns);
        });
    out
}

/// Takes the largest of each column of pixels that a row of windows holds, then the largest of those in each window.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn largest(shape: &ConvShape, plane: &[f32], out: &mut [f32], columns: &mut Vec<f32>) {
    let ((kh, kw), (ph, pw)) = (shape.kernel, shape.padding);
    for (oy, out) in out.chunks_exact_mut(shape.out_width()).enumerate() {
        // Below every number, left and right of the plane.
        columns.clear();
        columns.resize(shape.width + 2 * pw, f32::NEG_INFINITY);
        let inside = &mut columns[pw..pw + shape.width];
        for y in (oy * STEP).saturating_sub(ph)..(oy * STEP + kh - ph).min(shape.height) {
            for (column, &pixel) in inside.iter_mut().zip(&plane[y * shape.width..]) {
                *column = larger(*column, pixel);
            }
        }
        out.fill(f32::NEG_INFINITY);
        for kx in 0..kw {
            let seen = &columns[kx..][..(out.len() - 1) * STEP + 1];
            for (i, out) in out.iter_mut().enumerate() {
                *out = larger(*out, seen[i * STEP]);
            }
        }
    }
}

/// A NaN is larger than all, as in PyTorch: it must not be hidden.
#[inline(always)]
fn larger(value: f32, pixel: f32) -> f32 {
    if pixel > value || pixel.is_nan() {
        pixel
    } else {
        value
    }
}

/// The gradient by the input.
pub(crate) fn max_pool_gradient(shape: &ConvShape, x: &[f32], grad: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    out.par_chunks_mut(shape.in_pixels())
        .zip(x.par_chunks(shape.in_pixels()))
        .zip(grad.par_chunks(shape.out_pixels()))
        .with_min_len(8)
        .for_each_init(MaxIndices::default, |maxima, ((out, plane), grad)| {
            for (oy, grad) in grad.chunks_exact(shape.out_width()).enumerate() {
                maxima.find(shape, plane, oy);
                for (&at, g) in maxima.places.iter().zip(grad) {
                    out[at as usize] += g;
                }
            }
        });
    out
}

/// Calls back for every tap that row `oy` of windows has: the windows in which it lies inside the plane, and the place of
/// its pixel in the first of them.
fn for_each_tap(shape: &ConvShape, oy: usize, mut tap: impl FnMut(Range<usize>, u32)) {
    let ((kh, kw), (ph, pw)) = (shape.kernel, shape.padding);
    for y in (oy * STEP).saturating_sub(ph)..(oy * STEP + kh - ph).min(shape.height) {
        for kx in 0..kw {
            let first = pw.saturating_sub(kx).div_ceil(STEP);
            let end = (shape.width + pw - kx).div_ceil(STEP);
            let windows = first..end.min(shape.out_width());
            if !windows.is_empty() {
                tap(windows, (y * shape.width + first * STEP + kx - pw) as u32);
            }
        }
    }
}

/// Maxima of one row of windows, and their places.
#[derive(Default)]
struct MaxIndices {
    values: Vec<f32>,
    /// Places of the maxima in the plane.
    places: Vec<u32>,
}

impl MaxIndices {
    fn find(&mut self, shape: &ConvShape, plane: &[f32], oy: usize) {
        self.values.resize(shape.out_width(), 0.0);
        self.places.clear();
        self.places.resize(shape.out_width(), NOWHERE);
        for_each_tap(shape, oy, |windows, first| {
            let values = &mut self.values[windows.clone()];
            challenge(plane, first, values, &mut self.places[windows]);
        });
    }
}

/// The place of a winner not found yet.
const NOWHERE: u32 = u32::MAX;

/// Compares each window's winner so far with every `STEP`th pixel from place `first` on.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn challenge(plane: &[f32], first: u32, values: &mut [f32], places: &mut [u32]) {
    let n = values.len();
    let pixels = &plane[first as usize..][..(n - 1) * STEP + 1];
    let places = &mut places[..n];
    for i in 0..n {
        let pixel = pixels[i * STEP];
        let wins = places[i] == NOWHERE || pixel > values[i] || pixel.is_nan();
        let place = first + (i * STEP) as u32;
        values[i] = if wins { pixel } else { values[i] };
        places[i] = if wins { place } else { places[i] };
    }
}
