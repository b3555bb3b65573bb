//! Softmax of a row and its gradient.

use multiversion::multiversion;

use super::exponential::exp;
use super::sums::{LANES, sum_of};

/// A row x becomes exp(factor x) over its sum; `factor` is positive.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
pub(super) fn softmax_row(row: &mut [f32], factor: f32) {
    let mut tops = [f32::NEG_INFINITY; LANES];
    let (whole, rest) = row.as_chunks::<LANES>();
    for chunk in whole {
        for (top, &x) in tops.iter_mut().zip(chunk) {
            *top = if x > *top { x } else { *top };
        }
    }
    let larger = |a: f32, &b: &f32| if b > a { b } else { a };
    let top = rest.iter().chain(&tops).fold(f32::NEG_INFINITY, larger);
    for x in row.iter_mut() {
        *x = exp(factor * (*x - top));
    }
    let inverse = (1.0 / sum_of(row, |y| y)) as f32;
    for y in row {
        *y *= inverse;
    }
}

/// A row of gradients by y = [`softmax_row`] becomes that by x: `factor y (grad - Σ y grad)`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
pub(super) fn softmax_gradient_row(y: &[f32], grad: &mut [f32], factor: f32) {
    let mut sums = [0.0f64; LANES];
    for (y, grad) in y.chunks(LANES).zip(grad.chunks(LANES)) {
        for (sum, (y, g)) in sums.iter_mut().zip(y.iter().zip(grad)) {
            *sum += f64::from(y * g);
        }
    }
    let mean = sums.iter().sum::<f64>() as f32;
    for (g, y) in grad.iter_mut().zip(y) {
        *g = factor * y * (*g - mean);
    }
}
