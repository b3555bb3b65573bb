//! Operations of a transformer besides linear maps: attention by head, layer normalisation by row.

use candle_core::{Result, Tensor};

use super::cpu::{apply, are_fast};
use super::portable;
use crate::kernels::attention::{Heads, attend, attend_gradient};
use crate::kernels::layer_norm as norm;

/// [`portable::layer_norm`].
pub(crate) fn layer_norm(
    x: &Tensor,
    weight: &Tensor,
    bias: &Tensor,
    epsilon: f64,
) -> Result<Tensor> {
    let features = x.dims().last().copied().unwrap_or(0);
    let fits = [weight, bias].iter().all(|t| t.dims() == [features]);
    if !are_fast(&[x, weight, bias]) || x.elem_count() == 0 || !fits {
        return portable::layer_norm(x, weight, bias, epsilon);
    }
    apply(
        "layer_norm",
        [x, weight, bias],
        x.dims(),
        move |[x, weight, bias]| norm::layer_norm(x, weight, bias, epsilon),
        move |b| {
            let [x, weight, _] = b.inputs;
            norm::layer_norm_gradients(x, weight, b.grad, epsilon).map(Some)
        },
    )
}

/// [`portable::self_attention`].
pub(crate) fn self_attention(all: &Tensor, heads: usize) -> Result<Tensor> {
    let (batch, tokens, width) = all.dims3()?;
    let is_empty = batch * tokens * width * heads == 0;
    if !are_fast(&[all]) || is_empty || !width.is_multiple_of(3 * heads) {
        return portable::self_attention(all, heads);
    }
    let sizes = Heads {
        tokens,
        heads,
        depth: width / (3 * heads),
    };
    apply(
        "self_attention",
        [all],
        &[batch, tokens, width / 3],
        move |[all]| attend(all, sizes),
        move |b| [Some(attend_gradient(b.inputs[0], b.grad, sizes))],
    )
}
