//! Functions of elements and of rows, heavy ones in one pass forward and one backward.

use std::f64::consts::FRAC_1_SQRT_2;

use candle_core::{Result, Tensor};

use super::cpu::{apply, are_fast};
use super::portable;
use crate::kernels::{gelu as kernel, rectifier};
use crate::recording::{Graph, Value, float, int, ints, recorded};

/// [`portable::gelu`].
pub(crate) fn gelu(x: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        let [root, one, half] = [FRAC_1_SQRT_2, 1.0, 0.5].map(|n| g.number(n));
        let scaled = g.node("Mul", &[v[0], root], []);
        let erf = g.node("Erf", &[scaled], []);
        let twice_phi = g.node("Add", &[erf, one], []);
        let halved = g.node("Mul", &[v[0], half], []);
        g.node("Mul", &[halved, twice_phi], [])
    };
    recorded(&[x], nodes, || {
        if !are_fast(&[x]) {
            return portable::gelu(x);
        }
        let forward = |[x]: [&[f32]; 1]| kernel::gelu(x);
        apply("gelu", [x], x.dims(), forward, |b| {
            [Some(kernel::gelu_gradient(b.inputs[0], b.grad))]
        })
    })
}

/// [`portable::relu`].
pub(crate) fn relu(x: &Tensor) -> Result<Tensor> {
    recorded(&[x], |g, v| g.node("Relu", v, []), || portable::relu(x))
}

/// [`portable::leaky_relu`].
pub(crate) fn leaky_relu(x: &Tensor, slope: f64) -> Result<Tensor> {
    let alpha = float("alpha", slope);
    let nodes = |g: &mut Graph, v: &[Value]| g.node("LeakyRelu", v, [alpha]);
    recorded(&[x], nodes, || {
        if !are_fast(&[x]) {
            return portable::leaky_relu(x, slope);
        }
        let slope = slope as f32;
        let forward = move |[x]: [&[f32]; 1]| rectifier::leaky(x, slope);
        apply("leaky_relu", [x], x.dims(), forward, move |b| {
            [Some(rectifier::leaky_gradient(b.inputs[0], b.grad, slope))]
        })
    })
}

/// `relu(x + y)`, the end of a residual block, for tensors of the same shape.
pub(crate) fn add_relu(x: &Tensor, y: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        let sum = g.node("Add", v, []);
        g.node("Relu", &[sum], [])
    };
    recorded(&[x, y], nodes, || {
        if !are_fast(&[x, y]) || x.dims() != y.dims() {
            return portable::relu(&(x + y)?);
        }
        let forward = |[x, y]: [&[f32]; 2]| rectifier::add_relu(x, y);
        apply("add_relu", [x, y], x.dims(), forward, |b| {
            let through = rectifier::where_positive(b.output, b.grad);
            [Some(through.clone()), Some(through)]
        })
    })
}

/// [`portable::softmax_last`].
pub(crate) fn softmax(x: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| g.node("Softmax", v, [int("axis", -1)]);
    recorded(&[x], nodes, || portable::softmax_last(x))
}

/// [`portable::max_last`].
pub(crate) fn max_last(x: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        g.node("ReduceMax", v, [ints("axes", [-1]), int("keepdims", 1)])
    };
    recorded(&[x], nodes, || portable::max_last(x))
}
