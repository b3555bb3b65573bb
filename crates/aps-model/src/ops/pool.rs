//! Max pooling.

use candle_core::{Result, Tensor};

use super::cpu::{apply, are_fast};
use super::portable;
use crate::kernels::max_pool::{STEP, max_pool, max_pool_gradient};
use crate::kernels::{ConvShape, Steps};

/// [`portable::max_pool_2x2`].
pub(crate) fn max_pool_2x2(x: &Tensor) -> Result<Tensor> {
    match windows(x, 2, 0) {
        Some(windows) => pool(x, windows),
        None => portable::max_pool_2x2(x),
    }
}

/// [`portable::max_pool_3x3_s2_p1`].
pub(crate) fn max_pool_3x3_s2_p1(x: &Tensor) -> Result<Tensor> {
    match windows(x, 3, 1) {
        Some(windows) => pool(x, windows),
        None => portable::max_pool_3x3_s2_p1(x),
    }
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
        steps: Steps::new(STEP, (padding, padding)),
    };
    (are_fast(&[x]) && windows.is_valid()).then_some(windows)
}

fn pool(x: &Tensor, windows: ConvShape) -> Result<Tensor> {
    apply(
        "max_pool2d",
        [x],
        &windows.out_dims(),
        move |[x]| max_pool(&windows, x),
        move |b| [Some(max_pool_gradient(&windows, b.inputs[0], b.grad))],
    )
}
