//! The operations of the layers, each with the nodes of ONNX that compute the same in evaluation.

use std::f64::consts::FRAC_1_SQRT_2;

use candle_core::{Result, Tensor};

use super::portable::{self, BatchNormTensors, EPSILON};
use super::{activation, attention, conv2d as convolution, linear as affine, norm, pool};
use crate::recording::{Graph, Value, float, int, ints, recorded, word};

/// Computes [`affine::linear`].
pub(crate) fn linear(x: &Tensor, weight: &Tensor, bias: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        if x.rank() == 2 {
            return g.node("Gemm", v, [int("transB", 1)]);
        }
        let turned = g.node("Transpose", &v[1..2], [ints("perm", [1, 0])]);
        let product = g.node("MatMul", &[v[0], turned], []);
        g.node("Add", &[product, v[2]], [])
    };
    let compute = || affine::linear(x, weight, bias);
    recorded(&[x, weight, bias], nodes, compute)
}

/// Computes x Wᵀ of (rows, in) and (out, in).
pub(crate) fn project(x: &Tensor, weight: &Tensor) -> Result<Tensor> {
    recorded(
        &[x, weight],
        |g, v| g.node("Gemm", v, [int("transB", 1)]),
        || x.matmul(&weight.t()?),
    )
}

/// Computes [`convolution::conv2d`].
pub(crate) fn conv2d(
    x: &Tensor,
    weight: &Tensor,
    bias: Option<&Tensor>,
    stride: usize,
    padding: (usize, usize),
) -> Result<Tensor> {
    let inputs: Vec<_> = [x, weight].into_iter().chain(bias).collect();
    let nodes = |g: &mut Graph, v: &[Value]| {
        let (stride, (h, w)) = (stride as i64, (padding.0 as i64, padding.1 as i64));
        let settings = [ints("strides", [stride; 2]), ints("pads", [h, w, h, w])];
        g.node("Conv", v, settings)
    };
    let compute = || convolution::conv2d(x, weight, bias, stride, padding);
    recorded(&inputs, nodes, compute)
}

/// Computes the cross-correlation of `x` (batch, in, length) with `weight` (out, in, kernel), zeros around, and adds `bias` (out).
pub(crate) fn conv1d(x: &Tensor, weight: &Tensor, bias: &Tensor, padding: usize) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        let pads = ints("pads", [padding as i64; 2]);
        g.node("Conv", v, [pads])
    };
    recorded(&[x, weight, bias], nodes, || {
        // A line is an image of height 1.
        let (x, weight) = (x.unsqueeze(2)?, weight.unsqueeze(2)?);
        conv2d(&x, &weight, Some(bias), 1, (0, padding))?.squeeze(2)
    })
}

/// Computes [`convolution::conv_transpose2x2`].
pub(crate) fn conv_transpose2x2(x: &Tensor, weight: &Tensor, bias: &Tensor) -> Result<Tensor> {
    recorded(
        &[x, weight, bias],
        |g, v| g.node("ConvTranspose", v, [ints("strides", [2, 2])]),
        || convolution::conv_transpose2x2(x, weight, bias),
    )
}

/// Computes [`norm::batch_norm`].
pub(crate) fn batch_norm(x: &Tensor, tensors: BatchNormTensors<'_>, train: bool) -> Result<Tensor> {
    let compute = || norm::batch_norm(x, tensors, train);
    recorded(&inputs(x, &tensors), normalised, compute)
}

/// Computes [`norm::batch_norm_relu`].
pub(crate) fn batch_norm_relu(
    x: &Tensor,
    tensors: BatchNormTensors<'_>,
    train: bool,
) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        let y = normalised(g, v);
        g.node("Relu", &[y], [])
    };
    let compute = || norm::batch_norm_relu(x, tensors, train);
    recorded(&inputs(x, &tensors), nodes, compute)
}

fn inputs<'a>(x: &'a Tensor, t: &BatchNormTensors<'a>) -> [&'a Tensor; 5] {
    let (mean, variance) = (t.running_mean.as_tensor(), t.running_var.as_tensor());
    [x, t.weight, t.bias, mean, variance]
}

fn normalised(g: &mut Graph, v: &[Value]) -> Value {
    g.node("BatchNormalization", v, [float("epsilon", EPSILON)])
}

/// Computes [`attention::layer_norm`].
pub(crate) fn layer_norm(
    x: &Tensor,
    weight: &Tensor,
    bias: &Tensor,
    epsilon: f64,
) -> Result<Tensor> {
    recorded(
        &[x, weight, bias],
        |g, v| g.node("LayerNormalization", v, [float("epsilon", epsilon)]),
        || attention::layer_norm(x, weight, bias, epsilon),
    )
}

/// Computes [`attention::self_attention`].
pub(crate) fn self_attention(all: &Tensor, heads: usize) -> Result<Tensor> {
    let (_, tokens, width) = all.dims3()?;
    let width = width / 3;
    let nodes = |g: &mut Graph, v: &[Value]| {
        let depth = width / heads;
        let parts = g.reshape(v[0], &[tokens, 3, heads, depth]);
        let mut part = |n: usize, order: [i64; 4]| {
            let part = g.slice(parts, 2, [n, n + 1]);
            let part = g.reshape(part, &[tokens, heads, depth]);
            g.node("Transpose", &[part], [ints("perm", order)])
        };
        let (queries, keys) = (part(0, [0, 2, 1, 3]), part(1, [0, 2, 3, 1]));
        let values = part(2, [0, 2, 1, 3]);
        let factor = g.number(1.0 / (depth as f64).sqrt());
        let queries = g.node("Mul", &[queries, factor], []);
        let scores = g.node("MatMul", &[queries, keys], []);
        let shares = g.node("Softmax", &[scores], [int("axis", -1)]);
        let mixed = g.node("MatMul", &[shares, values], []);
        let mixed = g.node("Transpose", &[mixed], [ints("perm", [0, 2, 1, 3])]);
        g.reshape(mixed, &[tokens, width])
    };
    recorded(&[all], nodes, || attention::self_attention(all, heads))
}

/// Computes [`activation::gelu`].
pub(crate) fn gelu(x: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        let [root, one, half] = [FRAC_1_SQRT_2, 1.0, 0.5].map(|n| g.number(n));
        let scaled = g.node("Mul", &[v[0], root], []);
        let erf = g.node("Erf", &[scaled], []);
        let twice_phi = g.node("Add", &[erf, one], []);
        let halved = g.node("Mul", &[v[0], half], []);
        g.node("Mul", &[halved, twice_phi], [])
    };
    recorded(&[x], nodes, || activation::gelu(x))
}

/// Computes [`portable::relu`].
pub(crate) fn relu(x: &Tensor) -> Result<Tensor> {
    recorded(&[x], |g, v| g.node("Relu", v, []), || portable::relu(x))
}

/// Computes [`activation::leaky_relu`].
pub(crate) fn leaky_relu(x: &Tensor, slope: f64) -> Result<Tensor> {
    recorded(
        &[x],
        |g, v| g.node("LeakyRelu", v, [float("alpha", slope)]),
        || activation::leaky_relu(x, slope),
    )
}

/// Computes [`activation::add_relu`].
pub(crate) fn add_relu(x: &Tensor, y: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        let sum = g.node("Add", v, []);
        g.node("Relu", &[sum], [])
    };
    recorded(&[x, y], nodes, || activation::add_relu(x, y))
}

/// Computes [`portable::softmax_last`].
pub(crate) fn softmax(x: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| g.node("Softmax", v, [int("axis", -1)]);
    recorded(&[x], nodes, || portable::softmax_last(x))
}

/// Computes [`portable::max_last`].
pub(crate) fn max_last(x: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| g.node("ReduceMax", v, [ints("axes", [-1])]);
    recorded(&[x], nodes, || portable::max_last(x))
}

/// Computes [`pool::max_pool_2x2`].
pub(crate) fn max_pool_2x2(x: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| max_pool(g, v, 2, 0);
    recorded(&[x], nodes, || pool::max_pool_2x2(x))
}

/// Computes [`pool::max_pool_3x3_s2_p1`].
pub(crate) fn max_pool_3x3_s2_p1(x: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| max_pool(g, v, 3, 1);
    recorded(&[x], nodes, || pool::max_pool_3x3_s2_p1(x))
}

fn max_pool(g: &mut Graph, v: &[Value], kernel: i64, padding: i64) -> Value {
    let settings = [
        ints("kernel_shape", [kernel; 2]),
        ints("strides", [2, 2]),
        ints("pads", [padding; 4]),
    ];
    g.node("MaxPool", v, settings)
}

/// Computes [`portable::adaptive_avg_pool`].
pub(crate) fn adaptive_avg_pool(x: &Tensor, out: usize) -> Result<Tensor> {
    let (_, channels, height, width) = x.dims4()?;
    let nodes = |g: &mut Graph, v: &[Value]| {
        if out == 1 {
            return g.node("GlobalAveragePool", v, []);
        }
        let weights = portable::averages([height, width], out);
        let weights = g.numbers(&[height * width, out * out], &weights);
        let pixels = g.reshape(v[0], &[channels, height * width]);
        let means = g.node("MatMul", &[pixels, weights], []);
        g.reshape(means, &[channels, out, out])
    };
    recorded(&[x], nodes, || portable::adaptive_avg_pool(x, out))
}

/// Computes [`portable::resize_bilinear`].
pub(crate) fn resize_bilinear(x: &Tensor, height: usize, width: usize) -> Result<Tensor> {
    let (_, _, old_height, old_width) = x.dims4()?;
    let nodes = |g: &mut Graph, v: &[Value]| {
        if (old_height, old_width) == (height, width) {
            return v[0];
        }
        let columns = portable::interpolation(old_width, width);
        let rows = portable::interpolation(old_height, height);
        let columns = g.numbers(&[old_width, width], &columns);
        let rows = g.numbers(&[old_height, height], &rows);
        let rows = g.node("Transpose", &[rows], [ints("perm", [1, 0])]);
        let wide = g.node("MatMul", &[v[0], columns], []);
        g.node("MatMul", &[rows, wide], [])
    };
    let compute = || portable::resize_bilinear(x, height, width);
    recorded(&[x], nodes, compute)
}

/// Computes [`portable::upsample_nearest_2x`] of (batch, channels, length).
pub(crate) fn upsample_nearest_2x(x: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        let (none, scales) = (g.none(), g.numbers(&[3], &[1.0, 1.0, 2.0]));
        let settings = [
            word("mode", "nearest"),
            word("coordinate_transformation_mode", "asymmetric"),
            word("nearest_mode", "floor"),
        ];
        g.node("Resize", &[v[0], none, scales], settings)
    };
    recorded(&[x], nodes, || portable::upsample_nearest_2x(x))
}
