//! Depthwise convolution along a circle.

use candle_core::{Result, Tensor};

use super::cpu::{apply, are_fast};
use super::portable;
use crate::kernels::depthwise::{self as kernel, Depthwise};

/// [`portable::depthwise`], with f32 on the CPU in one pass forward and two backward.
pub(crate) fn depthwise(x: &Tensor, weight: &Tensor, dilation: usize) -> Result<Tensor> {
    let Some(sizes) = sizes(x, weight, dilation) else {
        return portable::depthwise(x, weight, dilation);
    };
    apply(
        "depthwise",
        [x, weight],
        x.dims(),
        move |[x, weight]| kernel::depthwise(&sizes, x, weight),
        move |b| {
            let [x, weight] = b.inputs;
            let by_input = b.wanted[0].then(|| kernel::by_input(&sizes, weight, b.grad));
            [by_input, Some(kernel::by_weight(&sizes, x, b.grad))]
        },
    )
}

/// Returns the sizes, if the fast path knows the tensors and they fit together.
fn sizes(x: &Tensor, weight: &Tensor, dilation: usize) -> Option<Depthwise> {
    let (_, channels, length) = x.dims3().ok()?;
    let (kernels, 1, taps) = weight.dims3().ok()? else {
        return None;
    };
    let sizes = Depthwise {
        channels,
        length,
        taps,
        dilation,
    };
    let fits = are_fast(&[x, weight]) && kernels == channels && sizes.is_valid();
    fits.then_some(sizes)
}
