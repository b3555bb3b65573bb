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

#[cfg(test)]
mod tests {
    use super::*;

    /// Values up to e^60 apart and far from 0, against the definition in f64.
    #[test]
    fn softmax_and_gradient_of_rows_of_any_length() {
        for len in [1, 2, 15, 16, 19, 197] {
            let x: Vec<f32> = (0..len)
                .map(|i| 500.0 + (i * 37 % 61) as f32 - 30.0)
                .collect();
            let grad: Vec<f32> = (0..len).map(|i| (i * 29 % 17) as f32 / 8.0 - 1.0).collect();
            let factor = 0.5;
            let exp = |x: f32| (factor * (f64::from(x) - 530.0)).exp();
            let sum: f64 = x.iter().map(|&x| exp(x)).sum();
            let expected: Vec<f64> = x.iter().map(|&x| exp(x) / sum).collect();
            let pairs = expected.iter().zip(&grad);
            let mean: f64 = pairs.map(|(y, &g)| y * f64::from(g)).sum();
            let mut y = x.clone();
            softmax_row(&mut y, factor as f32);
            let mut by_input = grad.clone();
            softmax_gradient_row(&y, &mut by_input, factor as f32);
            for i in 0..len {
                let slope = factor * expected[i] * (f64::from(grad[i]) - mean);
                assert!((f64::from(y[i]) - expected[i]).abs() < 1e-6, "{len}, {i}");
                assert!((f64::from(by_input[i]) - slope).abs() < 1e-6, "{len}, {i}");
            }
        }
    }
}
