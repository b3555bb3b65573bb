//! Pooling.

use candle_core::{Result, Tensor};

use super::cpu::{apply, are_fast};
use super::portable;
use crate::kernels::ConvShape;
use crate::kernels::max_pool::{STEP, max_pool, max_pool_gradient};
use crate::recording::{Graph, Value, ints, recorded};

/// [`portable::max_pool_2x2`].
pub(crate) fn max_pool_2x2(x: &Tensor) -> Result<Tensor> {
    pool(x, 2, 0, portable::max_pool_2x2)
}

/// [`portable::max_pool_3x3_s2_p1`].
pub(crate) fn max_pool_3x3_s2_p1(x: &Tensor) -> Result<Tensor> {
    pool(x, 3, 1, portable::max_pool_3x3_s2_p1)
}

fn pool(
    x: &Tensor,
    kernel: usize,
    padding: usize,
    portable: fn(&Tensor) -> Result<Tensor>,
) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        let settings = [
            ints("kernel_shape", [kernel as i64; 2]),
            ints("strides", [2, 2]),
            ints("pads", [padding as i64; 4]),
        ];
        g.node("MaxPool", v, settings)
    };
    recorded(&[x], nodes, || {
        let Some(windows) = windows(x, kernel, padding) else {
            return portable(x);
        };
        let forward = move |[x]: [&[f32]; 1]| max_pool(&windows, x);
        apply("max_pool2d", [x], &windows.out_dims(), forward, move |b| {
            [Some(max_pool_gradient(&windows, b.inputs[0], b.grad))]
        })
    })
}

/// Returns the sizes, if the fast path knows the tensor.
fn windows(x: &Tensor, kernel: usize, padding: usize) -> Option<ConvShape> {
    let (batch, channels, height, width) = x.dims4().ok()?;
    let windows = ConvShape {
        batch,
        in_channels: channels,
        height,
        width,
        out_channels: channels,
        kernel: (kernel, kernel),
        stride: STEP,
        padding: (padding, padding),
    };
    (are_fast(&[x]) && windows.is_valid()).then_some(windows)
}

/// [`portable::adaptive_avg_pool`].
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
