//! The end of a gated residual block, and the mean of rows that its gate sees.

use multiversion::multiversion;
use rayon::prelude::*;

use super::sums::sum_of;

/// Rows of one task.
const ROWS: usize = 64;

/// `x + gate * y`, for rows of `length` values with one gate each.
pub(crate) fn add_gated(x: &[f32], y: &[f32], gate: &[f32], length: usize) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    out.par_chunks_mut(length)
        .zip(x.par_chunks(length).zip(y.par_chunks(length)))
        .zip(gate)
        .with_min_len(ROWS)
        .for_each(|((out, (x, y)), &gate)| add_gated_row(x, y, gate, out));
    out
}

/// The gradients of [`add_gated`] by `y` and `gate`; that by `x` is `grad` itself.
pub(crate) fn gradients(
    y: &[f32],
    gate: &[f32],
    grad: &[f32],
    length: usize,
) -> (Vec<f32>, Vec<f32>) {
    let mut by_y = vec![0.0; y.len()];
    let mut by_gate = vec![0.0; gate.len()];
    by_y.par_chunks_mut(length)
        .zip(by_gate.par_iter_mut().zip(gate))
        .zip(y.par_chunks(length).zip(grad.par_chunks(length)))
        .with_min_len(ROWS)
        .for_each(|((by_y, (by_gate, &gate)), (y, grad))| {
            // Its place is free until the gradient by y takes it.
            multiply(y, grad, by_y);
            *by_gate = sum_of(by_y, |v| v) as f32;
            scale(grad, gate, by_y);
        });
    (by_y, by_gate)
}

/// The mean of each row of `length` values.
pub(crate) fn mean_rows(x: &[f32], length: usize) -> Vec<f32> {
    let mean = |row: &[f32]| (sum_of(row, |v| v) / length as f64) as f32;
    let rows = x.par_chunks(length).with_min_len(ROWS);
    rows.map(mean).collect()
}

/// The gradient of [`mean_rows`], from one value a row.
pub(crate) fn mean_rows_gradient(grad: &[f32], length: usize) -> Vec<f32> {
    let mut out = vec![0.0; grad.len() * length];
    out.par_chunks_mut(length)
        .zip(grad)
        .with_min_len(ROWS)
        .for_each(|(out, grad)| out.fill(grad / length as f32));
    out
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn add_gated_row(x: &[f32], y: &[f32], gate: f32, out: &mut [f32]) {
    for (out, (x, y)) in out.iter_mut().zip(x.iter().zip(y)) {
        *out = x + gate * y;
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn multiply(a: &[f32], b: &[f32], out: &mut [f32]) {
    for (out, (a, b)) in out.iter_mut().zip(a.iter().zip(b)) {
        *out = a * b;
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn scale(values: &[f32], factor: f32, out: &mut [f32]) {
    for (out, v) in out.iter_mut().zip(values) {
        *out = factor * v;
    }
}
