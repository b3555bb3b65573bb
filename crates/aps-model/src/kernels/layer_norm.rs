//! Layer normalisation of rows and its gradients.

use multiversion::multiversion;
use rayon::prelude::*;

use super::rows::{ROWS, sum_rows};
use super::sums::sum_of;

/// `(x - mean) / deviation * weight + bias` a row, as long as `weight`.
pub(crate) fn layer_norm(x: &[f32], weight: &[f32], bias: &[f32], epsilon: f64) -> Vec<f32> {
    let len = weight.len();
    let mut out = vec![0.0; x.len()];
    out.par_chunks_mut(len)
        .zip(x.par_chunks(len))
        .with_min_len(ROWS)
        .for_each(|(out, x)| normalise(x, weight, bias, epsilon, out));
    out
}

/// The gradients by `x`, `weight` and `bias`.
pub(crate) fn layer_norm_gradients(
    x: &[f32],
    weight: &[f32],
    grad: &[f32],
    epsilon: f64,
) -> [Vec<f32>; 3] {
    let len = weight.len();
    let mut by_input = vec![0.0; x.len()];
    let mut products = vec![0.0; x.len()];
    by_input
        .par_chunks_mut(len)
        .zip(products.par_chunks_mut(len))
        .zip(x.par_chunks(len).zip(grad.par_chunks(len)))
        .with_min_len(ROWS)
        .for_each(|((out, product), (x, grad))| {
            gradient(x, weight, grad, epsilon, product, out);
        });
    [by_input, sum_rows(&products, len), sum_rows(grad, len)]
}

/// Mean of a row, and the inverse of its deviation.
#[inline(always)]
fn moments(x: &[f32], epsilon: f64) -> (f32, f32) {
    let n = x.len() as f64;
    let mean = (sum_of(x, |v| v) / n) as f32;
    // About the mean, so that squares do not cancel.
    let variance = sum_of(x, |v| (v - mean) * (v - mean)) / n;
    (mean, (1.0 / (variance + epsilon).sqrt()) as f32)
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn normalise(x: &[f32], weight: &[f32], bias: &[f32], epsilon: f64, out: &mut [f32]) {
    let (mean, inverse) = moments(x, epsilon);
    let factors = weight.iter().zip(bias);
    for ((out, x), (w, b)) in out.iter_mut().zip(x).zip(factors) {
        *out = (x - mean) * inverse * w + b;
    }
}

/// With x^ the normalised row and h = grad * weight: `(h - mean(h) - x^ mean(h x^)) / deviation` into `out`, and `grad * x^`
/// into `product`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn gradient(
    x: &[f32],
    weight: &[f32],
    grad: &[f32],
    epsilon: f64,
    product: &mut [f32],
    out: &mut [f32],
) {
    let n = x.len() as f64;
    let (mean, inverse) = moments(x, epsilon);
    for ((out, g), w) in out.iter_mut().zip(grad).zip(weight) {
        *out = g * w;
    }
    let mean_h = (sum_of(out, |h| h) / n) as f32;
    for ((product, h), x) in product.iter_mut().zip(&*out).zip(x) {
        *product = h * ((x - mean) * inverse);
    }
    let mean_product = (sum_of(product, |p| p) / n) as f32;
    for ((out, product), (x, g)) in out.iter_mut().zip(product).zip(x.iter().zip(grad)) {
        let normal = (x - mean) * inverse;
        *out = inverse * (*out - mean_h - normal * mean_product);
        *product = g * normal;
    }
}
