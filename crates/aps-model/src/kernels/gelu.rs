//! The Gaussian error linear unit x Φ(x) and its gradient.

use multiversion::multiversion;

use super::each::zip_with;
use super::exponential::normal;

pub(crate) fn gelu(x: &[f32]) -> Vec<f32> {
    zip_with(x, x, |x, _, out| gelu_of(x, out))
}

/// `grad` times Φ(x) + x φ(x).
pub(crate) fn gelu_gradient(x: &[f32], grad: &[f32]) -> Vec<f32> {
    zip_with(x, grad, |x, grad, out| {
        out.copy_from_slice(grad);
        multiply_by_slope(x, out);
    })
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
pub(super) fn gelu_of(x: &[f32], out: &mut [f32]) {
    for (out, &x) in out.iter_mut().zip(x) {
        let (_, below) = normal(x);
        *out = x * below;
    }
}

/// [`gelu_gradient`] in place.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
pub(super) fn multiply_by_slope(x: &[f32], grad: &mut [f32]) {
    for (g, &x) in grad.iter_mut().zip(x) {
        let (density, below) = normal(x);
        *g *= below + x * density;
    }
}
