//! One-dimensional circular convolution of each channel with a kernel of its own, and its gradients.

use multiversion::multiversion;
use rayon::prelude::*;

/// Values computed together.
const LANES: usize = 16;

/// Sizes of a depthwise convolution of (batch, channel, place) with kernels (channel, tap), of an odd number of taps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Depthwise {
    pub channels: usize,
    pub length: usize,
    pub taps: usize,
    /// Places from tap to tap.
    pub dilation: usize,
}

impl Depthwise {
    /// Places that a kernel reaches to either side.
    pub fn reach(&self) -> usize {
        self.taps / 2 * self.dilation
    }

    /// Returns true when no kernel reaches around the circle more than once, and no size is zero.
    pub fn is_valid(&self) -> bool {
        self.channels * self.length * self.dilation > 0
            && !self.taps.is_multiple_of(2)
            && self.reach() <= self.length
    }

    /// Writes a row with so many places of its other end on either side, and any values up to whole vectors.
    pub(super) fn wrap(&self, row: &[f32], out: &mut Vec<f32>) {
        let (reach, length) = (self.reach(), self.length);
        out.resize(length.next_multiple_of(LANES) + 2 * reach, 0.0);
        out[..reach].copy_from_slice(&row[length - reach..]);
        out[reach..][..length].copy_from_slice(row);
        out[reach + length..][..reach].copy_from_slice(&row[..reach]);
    }
}

/// `x` (batch, channel, place) convolved with `weight` (channel, tap).
pub(crate) fn depthwise(s: &Depthwise, x: &[f32], weight: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    let image = s.channels * s.length;
    out.par_chunks_mut(image)
        .zip(x.par_chunks(image))
        .for_each_init(Vec::new, |wrapped, (out, x)| {
            let rows = out.chunks_exact_mut(s.length).zip(x.chunks_exact(s.length));
            for ((out, x), weight) in rows.zip(weight.chunks_exact(s.taps)) {
                s.wrap(x, wrapped);
                correlate(wrapped, weight, s.dilation, out);
            }
        });
    out
}

/// The gradient by `x`.
pub(crate) fn by_input(s: &Depthwise, weight: &[f32], grad: &[f32]) -> Vec<f32> {
    let mut turned = weight.to_vec();
    turned.chunks_exact_mut(s.taps).for_each(<[f32]>::reverse);
    depthwise(s, grad, &turned)
}

/// The gradient by `weight`.
pub(crate) fn by_weight(s: &Depthwise, x: &[f32], grad: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; s.channels * s.taps];
    let image = s.channels * s.length;
    out.par_chunks_mut(s.taps)
        .enumerate()
        .for_each_init(Vec::new, |wrapped, (channel, out)| {
            let mut sums = vec![0.0_f64; s.taps];
            for (x, grad) in x.chunks_exact(image).zip(grad.chunks_exact(image)) {
                let row = channel * s.length..(channel + 1) * s.length;
                s.wrap(&x[row.clone()], wrapped);
                for (tap, sum) in sums.iter_mut().enumerate() {
                    *sum += f64::from(dot(&wrapped[tap * s.dilation..], &grad[row.clone()]));
                }
            }
            for (out, sum) in out.iter_mut().zip(sums) {
                *out = sum as f32;
            }
        });
    out
}

/// `out` from a wrapped row.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
pub(super) fn correlate(wrapped: &[f32], weight: &[f32], dilation: usize, out: &mut [f32]) {
    for (block, out) in out.chunks_mut(LANES).enumerate() {
        let mut sums = [0.0; LANES];
        for (tap, w) in weight.iter().enumerate() {
            let from = &wrapped[block * LANES + tap * dilation..][..LANES];
            for (sum, v) in sums.iter_mut().zip(from) {
                *sum += w * v;
            }
        }
        out.copy_from_slice(&sums[..out.len()]);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0; LANES];
    for (a, b) in a.chunks(LANES).zip(b.chunks(LANES)) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().sum()
}
