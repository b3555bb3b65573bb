//! The end of a gated residual block, and the mean of rows that its gate sees.

use candle_core::{D, Result, Tensor};

use super::cpu::{apply, are_fast};
use super::portable::{self, at_least_f32};
use crate::kernels::gated as kernel;

/// [`portable::add_gated`], in one pass forward and one backward.
pub(crate) fn add_gated(x: &Tensor, y: &Tensor, gate: &Tensor) -> Result<Tensor> {
    let fits = match (x.dims(), gate.dims()) {
        (&[n, channels, length], gates) => gates == [n, channels] && n * channels * length > 0,
        _ => false,
    };
    if !are_fast(&[x, y, gate]) || x.dims() != y.dims() || !fits {
        return portable::add_gated(x, y, gate);
    }
    let length = x.dim(D::Minus1)?;
    apply(
        "add_gated",
        [x, y, gate],
        x.dims(),
        move |[x, y, gate]| kernel::add_gated(x, y, gate, length),
        move |b| {
            let [_, y, gate] = b.inputs;
            let (by_y, by_gate) = kernel::gradients(y, gate, b.grad, length);
            [Some(b.grad.to_vec()), Some(by_y), Some(by_gate)]
        },
    )
}

/// The mean over the last dimension, which is dropped.
pub(crate) fn mean_last(x: &Tensor) -> Result<Tensor> {
    let portable = || at_least_f32(x)?.mean(D::Minus1)?.to_dtype(x.dtype());
    let Some((&length, rows)) = x.dims().split_last() else {
        return portable();
    };
    if !are_fast(&[x]) || x.elem_count() == 0 {
        return portable();
    }
    apply(
        "mean_last",
        [x],
        rows,
        move |[x]| kernel::mean_rows(x, length),
        move |b| [Some(kernel::mean_rows_gradient(b.grad, length))],
    )
}
