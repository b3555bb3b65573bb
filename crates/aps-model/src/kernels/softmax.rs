//! Softmax of rows and its gradient.

use multiversion::multiversion;
use rayon::prelude::*;

use super::exponential::exp;
use super::sums::{LANES, sum_of};

/// exp(x) over its sum, in rows of `len`.
pub(crate) fn softmax(x: &[f32], len: usize) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    let rows = out.par_chunks_mut(len).zip(x.par_chunks(len));
    rows.with_min_len(rows_at_once(len))
        .for_each(|(out, x)| softmax_of(x, out));
    out
}

/// `y (grad - Σ y grad)` a row, `y` being the softmax.
pub(crate) fn softmax_gradient(y: &[f32], grad: &[f32], len: usize) -> Vec<f32> {
    let mut out = vec![0.0; y.len()];
    let rows = y.par_chunks(len).zip(grad.par_chunks(len));
    out.par_chunks_mut(len)
        .zip(rows)
        .with_min_len(rows_at_once(len))
        .for_each(|(out, (y, grad))| softmax_gradient_of(y, grad, out));
    out
}

/// Rows of one task.
fn rows_at_once(len: usize) -> usize {
    (1 << 14) / len.max(1) + 1
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn softmax_of(x: &[f32], out: &mut [f32]) {
    let mut tops = [f32::NEG_INFINITY; LANES];
    let (whole, rest) = x.as_chunks::<LANES>();
    for chunk in whole {
        for (top, &x) in tops.iter_mut().zip(chunk) {
            *top = if x > *top { x } else { *top };
        }
    }
    let top = rest
        .iter()
        .chain(&tops)
        .fold(f32::NEG_INFINITY, |a, &b| if b > a { b } else { a });
    for (out, x) in out.iter_mut().zip(x) {
        *out = exp(x - top);
    }
    let factor = (1.0 / sum_of(out, |y| y)) as f32;
    for out in out {
        *out *= factor;
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn softmax_gradient_of(y: &[f32], grad: &[f32], out: &mut [f32]) {
    for (out, (y, g)) in out.iter_mut().zip(y.iter().zip(grad)) {
        *out = y * g;
    }
    let mean = sum_of(out, |v| v) as f32;
    for (out, (y, g)) in out.iter_mut().zip(y.iter().zip(grad)) {
        *out = y * (g - mean);
    }
}
