//! Rectification and its gradient, plain and leaky.

use multiversion::multiversion;

use super::each::zip_with;

/// `max(x + y, 0)`, NaN where the sum is NaN.
pub(crate) fn add_relu(x: &[f32], y: &[f32]) -> Vec<f32> {
    zip_with(x, y, add_relu_of)
}

/// `grad` where `result` is above 0, else 0.
pub(crate) fn where_positive(result: &[f32], grad: &[f32]) -> Vec<f32> {
    zip_with(result, grad, where_positive_of)
}

/// `x` where it is above 0, else `slope * x`.
pub(crate) fn leaky(x: &[f32], slope: f32) -> Vec<f32> {
    zip_with(x, x, |x, _, out| leaky_of(x, slope, out))
}

/// `grad` where `x` is above 0, else `slope * grad`.
pub(crate) fn leaky_gradient(x: &[f32], grad: &[f32], slope: f32) -> Vec<f32> {
    zip_with(x, grad, |x, grad, out| {
        leaky_gradient_of(x, grad, slope, out)
    })
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

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn leaky_of(x: &[f32], slope: f32, out: &mut [f32]) {
    for (out, x) in out.iter_mut().zip(x) {
        *out = if *x > 0.0 { *x } else { slope * x };
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn leaky_gradient_of(x: &[f32], grad: &[f32], slope: f32, out: &mut [f32]) {
    for (out, (x, g)) in out.iter_mut().zip(x.iter().zip(grad)) {
        *out = if *x <= 0.0 { slope * g } else { *g };
    }
}
