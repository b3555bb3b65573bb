//! The affine map on the CPU.

use candle_core::{CpuStorage, CustomOp3, Layout, Result, Shape, Tensor};

use super::storage::{are_fast, made, slice, with_slices};
use crate::kernels::linear as kernel;
use crate::portable;

/// [`portable::linear`]: with f32 on the CPU the bias is there before the product is added to it, and gradients come in the
/// layout of their tensors instead of being turned afterwards.
pub fn linear(x: &Tensor, weight: &Tensor, bias: &Tensor) -> crate::Result<Tensor> {
    let fits = match (x.dims(), weight.dims(), bias.dims()) {
        ([.., inputs], [outputs, columns], [biases]) => inputs == columns && outputs == biases,
        _ => false,
    };
    let is_empty = x.elem_count() == 0 || weight.elem_count() == 0;
    if !are_fast(&[x, weight, bias]) || !fits || is_empty {
        return portable::linear(x, weight, bias);
    }
    let (weight, bias) = (weight.contiguous()?, bias.contiguous()?);
    Ok(x.contiguous()?.apply_op3(&weight, &bias, Linear)?)
}

struct Linear;

impl CustomOp3 for Linear {
    fn name(&self) -> &'static str {
        "linear"
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
        let bias = slice(bias, bias_layout)?;
        let y = kernel::linear(slice(x, x_layout)?, slice(weight, weight_layout)?, bias);
        let mut dims = x_layout.dims().to_vec();
        if let Some(last) = dims.last_mut() {
            *last = bias.len();
        }
        made(y, dims)
    }

    fn bwd(
        &self,
        x: &Tensor,
        weight: &Tensor,
        bias: &Tensor,
        _: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>, Option<Tensor>)> {
        let (outputs, inputs) = weight.dims2()?;
        let grad = grad.contiguous()?;
        let (by_input, (by_weight, by_bias)) = with_slices([x, weight, &grad], |[x_, w, g]| {
            let by_input = x.track_op().then(|| kernel::by_input(w, g, inputs));
            (by_input, kernel::by_weight_and_bias(x_, g, outputs))
        })?;
        let like = |values, t: &Tensor| Tensor::from_vec(values, t.shape(), t.device());
        Ok((
            by_input.map(|values| like(values, x)).transpose()?,
            Some(like(by_weight, weight)?),
            Some(like(by_bias, bias)?),
        ))
    }
}
