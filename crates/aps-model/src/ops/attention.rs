//! Operations of a transformer besides linear maps, on the CPU: attention by head, softmax and layer normalisation by row.

use candle_core::{CpuStorage, CustomOp1, CustomOp3, Layout, Result, Shape, Tensor};

use super::storage::{are_fast, made, slice, with_slices};
use crate::kernels::attention::{Heads, attend, attend_gradient};
use crate::kernels::{layer_norm as norm, softmax as kernel};
use crate::portable;

/// [`portable::softmax_last`].
pub fn softmax_last(x: &Tensor) -> crate::Result<Tensor> {
    match are_fast(&[x]) && x.elem_count() > 0 && x.rank() > 0 {
        true => Ok(x.contiguous()?.apply_op1(Softmax)?),
        false => portable::softmax_last(x),
    }
}

/// [`portable::layer_norm`].
pub fn layer_norm(
    x: &Tensor,
    weight: &Tensor,
    bias: &Tensor,
    epsilon: f64,
) -> crate::Result<Tensor> {
    let features = x.dims().last().copied().unwrap_or(0);
    let fits = [weight, bias].iter().all(|t| t.dims() == [features]);
    if !are_fast(&[x, weight, bias]) || x.elem_count() == 0 || !fits {
        return portable::layer_norm(x, weight, bias, epsilon);
    }
    let (weight, bias) = (weight.contiguous()?, bias.contiguous()?);
    Ok(x.contiguous()?
        .apply_op3(&weight, &bias, LayerNorm { epsilon })?)
}

/// [`portable::self_attention`].
pub fn self_attention(all: &Tensor, heads: usize) -> crate::Result<Tensor> {
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
    Ok(all.contiguous()?.apply_op1(Attention(sizes))?)
}

struct Attention(Heads);

impl CustomOp1 for Attention {
    fn name(&self) -> &'static str {
        "self_attention"
    }

    fn cpu_fwd(&self, all: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        let (batch, tokens, width) = layout.shape().dims3()?;
        let y = attend(slice(all, layout)?, self.0);
        made(y, (batch, tokens, width / 3))
    }

    fn bwd(&self, all: &Tensor, _: &Tensor, grad: &Tensor) -> Result<Option<Tensor>> {
        let through = with_slices([all, &grad.contiguous()?], |[all, g]| {
            attend_gradient(all, g, self.0)
        })?;
        Tensor::from_vec(through, all.shape(), all.device()).map(Some)
    }
}

struct Softmax;

impl CustomOp1 for Softmax {
    fn name(&self) -> &'static str {
        "softmax"
    }

    fn cpu_fwd(&self, x: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        let len = layout.dims().last().copied().unwrap_or(1);
        made(
            kernel::softmax(slice(x, layout)?, len),
            layout.shape().clone(),
        )
    }

    fn bwd(&self, x: &Tensor, y: &Tensor, grad: &Tensor) -> Result<Option<Tensor>> {
        let len = x.dims().last().copied().unwrap_or(1);
        let through = with_slices([y, &grad.contiguous()?], |[y, g]| {
            kernel::softmax_gradient(y, g, len)
        })?;
        Tensor::from_vec(through, x.shape(), x.device()).map(Some)
    }
}

struct LayerNorm {
    epsilon: f64,
}

impl CustomOp3 for LayerNorm {
    fn name(&self) -> &'static str {
        "layer_norm"
    }

    fn cpu_fwd(
        &self,
        x: &CpuStorage,
        x_layout: &Layout,
        weight: &CpuStorage,
        weight_layout: &Layout,
        bias: &CpuStorage,
        bias_layout: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let weight = slice(weight, weight_layout)?;
        let bias = slice(bias, bias_layout)?;
        let y = norm::layer_norm(slice(x, x_layout)?, weight, bias, self.epsilon);
        made(y, x_layout.shape().clone())
    }

    fn bwd(
        &self,
        x: &Tensor,
        weight: &Tensor,
        _: &Tensor,
        _: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>, Option<Tensor>)> {
        let [by_input, by_weight, by_bias] =
            with_slices([x, weight, &grad.contiguous()?], |[x, w, g]| {
                norm::layer_norm_gradients(x, w, g, self.epsilon)
            })?;
        let of_features = |values| Tensor::from_vec(values, weight.shape(), weight.device());
        Ok((
            Some(Tensor::from_vec(by_input, x.shape(), x.device())?),
            Some(of_features(by_weight)?),
            Some(of_features(by_bias)?),
        ))
    }
}
