//! Rectification and its gradient.

use multiversion::multiversion;
use rayon::prelude::*;

/// Values of one task.
const CHUNK: usize = 1 << 14;

/// `max(x + y, 0)`, NaN where the sum is NaN.
pub(crate) fn add_relu(x: &[f32], y: &[f32]) -> Vec<f32> {
    zip_with(x, y, add_relu_of)
}

/// `grad` where `result` is above 0, else 0.
pub(crate) fn where_positive(result: &[f32], grad: &[f32]) -> Vec<f32> {
    zip_with(result, grad, where_positive_of)
}

fn zip_with(x: &[f32], y: &[f32], f: impl Fn(&[f32], &[f32], &mut [f32]) + Sync) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    out.par_chunks_mut(CHUNK)
        .zip(x.par_chunks(CHUNK).zip(y.par_chunks(CHUNK)))
        .for_each(|(out, (x, y))| f(x, y, out));
    out
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn add_relu_of(x: &[f32], y: &[f32], out: &mut [f32]) {
    for (out, (x, y)) in out.iter_mut().zip(x.iter().zip(y)) {
        let sum = x + y;
        *out = if sum < 0.0 { 0.0 } else { sum };
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn where_positive_of(result: &[f32], grad: &[f32], out: &mut [f32]) {
    for (out, (r, g)) in out.iter_mut().zip(result.iter().zip(grad)) {
        *out = if *r <= 0.0 { 0.0 } else { *g };
    }
}
