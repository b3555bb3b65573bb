//! The affine map of rows, and its gradients.

use rayon::prelude::*;

use super::matmul::{Matrix, multiply_on_all_threads};
use super::rows::{ROWS, sum_rows};

/// `x Wᵀ + b` of rows `x`, with `weight` (out, in).
pub(crate) fn linear(x: &[f32], weight: &[f32], bias: &[f32]) -> Vec<f32> {
    let (outputs, inputs) = (bias.len(), weight.len() / bias.len());
    let mut out = vec![0.0; x.len() / inputs * outputs];
    out.par_chunks_mut(outputs)
        .with_min_len(ROWS)
        .for_each(|row| row.copy_from_slice(bias));
    // Rows of the result are the columns that the product writes.
    let sizes = (outputs, x.len() / inputs, inputs);
    let (a, b) = (Matrix::rows(weight, inputs), Matrix::columns(x, inputs));
    multiply_on_all_threads(sizes, a, b, &mut out, outputs, true);
    out
}

/// The gradient by `x`: `grad W`.
pub(crate) fn by_input(weight: &[f32], grad: &[f32], inputs: usize) -> Vec<f32> {
    let outputs = weight.len() / inputs;
    let rows = grad.len() / outputs;
    let mut out = vec![0.0; rows * inputs];
    let a = Matrix::columns(weight, inputs);
    let b = Matrix::columns(grad, outputs);
    multiply_on_all_threads((inputs, rows, outputs), a, b, &mut out, inputs, false);
    out
}

/// The gradients by weight, `gradᵀ x`, and bias.
pub(crate) fn by_weight_and_bias(x: &[f32], grad: &[f32], outputs: usize) -> (Vec<f32>, Vec<f32>) {
    let rows = grad.len() / outputs;
    let inputs = x.len() / rows;
    let mut out = vec![0.0; outputs * inputs];
    let (a, b) = (Matrix::columns(x, inputs), Matrix::rows(grad, outputs));
    multiply_on_all_threads((inputs, outputs, rows), a, b, &mut out, inputs, false);
    (out, sum_rows(grad, outputs))
}
