//! Activations, each in one pass forward and one backward.

use candle_core::{Result, Tensor};

use super::cpu::{apply, are_fast};
use super::portable;
use crate::kernels::{gelu as kernel, rectifier};

/// [`portable::gelu`].
pub(crate) fn gelu(x: &Tensor) -> Result<Tensor> {
    if !are_fast(&[x]) {
        return portable::gelu(x);
    }
    apply(
        "gelu",
        [x],
        x.dims(),
        |[x]| kernel::gelu(x),
        |b| [Some(kernel::gelu_gradient(b.inputs[0], b.grad))],
    )
}

/// [`portable::leaky_relu`].
pub(crate) fn leaky_relu(x: &Tensor, slope: f64) -> Result<Tensor> {
    if !are_fast(&[x]) {
        return portable::leaky_relu(x, slope);
    }
    let slope = slope as f32;
    apply(
        "leaky_relu",
        [x],
        x.dims(),
        move |[x]| rectifier::leaky(x, slope),
        move |b| [Some(rectifier::leaky_gradient(b.inputs[0], b.grad, slope))],
    )
}

/// `relu(x + y)`, the end of a residual block, for tensors of the same shape.
pub(crate) fn add_relu(x: &Tensor, y: &Tensor) -> Result<Tensor> {
    if !are_fast(&[x, y]) || x.dims() != y.dims() {
        return portable::relu(&(x + y)?);
    }
    apply(
        "add_relu",
        [x, y],
        x.dims(),
        |[x, y]| rectifier::add_relu(x, y),
        |b| {
            let through = rectifier::where_positive(b.output, b.grad);
            [Some(through.clone()), Some(through)]
        },
    )
}
