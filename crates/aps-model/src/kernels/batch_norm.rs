//! Batch normalisation of (batch, channel, pixel), optionally followed by ReLU.

use multiversion::multiversion;
use rayon::prelude::*;

use super::sums::LANES;

/// Mean and biased variance of each channel over batch and pixels, summed in f64 over deviations from the channel's first value.
pub(crate) fn moments(x: &[f32], channels: usize, pixels: usize) -> (Vec<f32>, Vec<f32>) {
    let count = (x.len() / channels) as f64;
    (0..channels)
        .into_par_iter()
        .with_min_len(4)
        .map(|c| {
            let planes = || {
                x.chunks_exact(channels * pixels)
                    .map(|image| &image[c * pixels..][..pixels])
            };
            // Near the mean, so that squares do not cancel.
            let pivot = planes().next().map_or(0.0, |p| p[0]);
            let (mut sum, mut squares) = (0.0, 0.0);
            for plane in planes() {
                let (s, q) = sums_around(plane, pivot);
                sum += s;
                squares += q;
            }
            let mean = sum / count;
            let variance = (squares / count - mean * mean).max(0.0);
            ((f64::from(pivot) + mean) as f32, variance as f32)
        })
        .unzip()
}

/// `y = scale * (x - mean) + shift` a channel, then ReLU if asked for.
pub(crate) fn scale_shift(
    x: &[f32],
    mean: &[f32],
    scale: &[f32],
    shift: &[f32],
    pixels: usize,
    relu: bool,
) -> Vec<f32> {
    let channels = scale.len();
    let mut out = vec![0.0; x.len()];
    let image = channels * pixels;
    out.par_chunks_mut(image)
        .zip(x.par_chunks(image))
        .for_each(|(out, x)| {
            let planes = out.chunks_exact_mut(pixels).zip(x.chunks_exact(pixels));
            for (c, (out, x)) in planes.enumerate() {
                let floor = if relu { 0.0 } else { f32::NEG_INFINITY };
                affine(x, mean[c], scale[c], shift[c], floor, out);
            }
        });
    out
}

/// Returns the sums that the gradient of a normalised channel needs, over batch and pixels: of the gradient, and of the
/// gradient times the normalised input. Where `y` is given (the output of ReLU), only places above 0 count.
pub(crate) fn gradient_sums(
    x: &[f32],
    y: Option<&[f32]>,
    grad: &[f32],
    moments: (&[f32], &[f32]),
    pixels: usize,
) -> (Vec<f32>, Vec<f32>) {
    let (mean, inverse_std) = moments;
    let channels = mean.len();
    (0..channels)
        .into_par_iter()
        .with_min_len(4)
        .map(|c| {
            let (mut sum, mut product) = (0.0, 0.0);
            for start in (c * pixels..x.len()).step_by(channels * pixels) {
                let range = start..start + pixels;
                let y = y.map_or(ALWAYS, |y| &y[range.clone()]);
                let (s, p) = gradient_sums_of(&x[range.clone()], y, &grad[range], mean[c]);
                sum += s;
                product += p;
            }
            (sum as f32, (product * f64::from(inverse_std[c])) as f32)
        })
        .unzip()
}

/// Output of which every place counts.
const ALWAYS: &[f32] = &[];

/// The gradient by the input: `a * grad + b * (x - mean) + d` a channel, `grad` only where ReLU let it through.
pub(crate) fn gradient(
    x: &[f32],
    y: Option<&[f32]>,
    grad: &[f32],
    factors: &[[f32; 4]],
    pixels: usize,
) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    let image = factors.len() * pixels;
    out.par_chunks_mut(image).enumerate().for_each(|(n, out)| {
        for (c, out) in out.chunks_exact_mut(pixels).enumerate() {
            let start = n * image + c * pixels;
            let range = start..start + pixels;
            let y = y.map_or(ALWAYS, |y| &y[range.clone()]);
            gradient_of(&x[range.clone()], y, &grad[range], factors[c], out);
        }
    });
    out
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn sums_around(plane: &[f32], pivot: f32) -> (f64, f64) {
    let (mut sum, mut squares) = ([0.0; LANES], [0.0; LANES]);
    let chunks = plane.chunks_exact(LANES);
    let rest = chunks.remainder();
    for chunk in chunks {
        for i in 0..LANES {
            let d = f64::from(chunk[i]) - f64::from(pivot);
            sum[i] += d;
            squares[i] += d * d;
        }
    }
    for (i, &v) in rest.iter().enumerate() {
        let d = f64::from(v) - f64::from(pivot);
        sum[i] += d;
        squares[i] += d * d;
    }
    (sum.iter().sum(), squares.iter().sum())
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn affine(x: &[f32], mean: f32, scale: f32, shift: f32, floor: f32, out: &mut [f32]) {
    for (out, &x) in out.iter_mut().zip(x) {
        let v = (x - mean) * scale + shift;
        // Not `max`: a NaN must stay one.
        *out = if v < floor { floor } else { v };
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn gradient_sums_of(x: &[f32], y: &[f32], grad: &[f32], mean: f32) -> (f64, f64) {
    let (mut sum, mut product) = ([0.0f64; LANES], [0.0f64; LANES]);
    let masked = !y.is_empty();
    let n = x.len();
    let (x, grad) = (&x[..n], &grad[..n]);
    let mut start = 0;
    while start < n {
        let end = n.min(start + LANES);
        for i in start..end {
            let g = if masked && y[i] <= 0.0 { 0.0 } else { grad[i] };
            sum[i - start] += f64::from(g);
            product[i - start] += f64::from(g) * f64::from(x[i] - mean);
        }
        start = end;
    }
    (sum.iter().sum(), product.iter().sum())
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn gradient_of(x: &[f32], y: &[f32], grad: &[f32], [a, b, d, mean]: [f32; 4], out: &mut [f32]) {
    let n = out.len();
    let (x, grad) = (&x[..n], &grad[..n]);
    if y.is_empty() {
        for i in 0..n {
            out[i] = a * grad[i] + b * (x[i] - mean) + d;
        }
    } else {
        let y = &y[..n];
        for i in 0..n {
            let g = if y[i] <= 0.0 { 0.0 } else { grad[i] };
            out[i] = a * g + b * (x[i] - mean) + d;
        }
    }
}
