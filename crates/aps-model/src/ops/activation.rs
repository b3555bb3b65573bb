//! Rectification on the CPU.

use candle_core::{CpuStorage, CustomOp2, Layout, Result, Shape, Tensor};

use super::storage::{are_fast, made, slice, with_slices};
use crate::kernels::rectifier::{add_relu as add_relu_values, where_positive};
use crate::portable;

/// `relu(x + y)`, the end of a residual block, for tensors of the same shape: in one pass with f32 on the CPU.
pub fn add_relu(x: &Tensor, y: &Tensor) -> crate::Result<Tensor> {
    if !are_fast(&[x, y]) || x.dims() != y.dims() {
        return portable::relu(&(x + y)?);
    }
    Ok(x.contiguous()?.apply_op2(&y.contiguous()?, AddRelu)?)
}

struct AddRelu;

impl CustomOp2 for AddRelu {
    fn name(&self) -> &'static str {
        "add_relu"
    }

    fn cpu_fwd(
        &self,
        x: &CpuStorage,
        x_layout: &Layout,
        y: &CpuStorage,
        y_layout: &Layout,
    ) -> Result<(CpuStorage, Shape)> {
        let sum = add_relu_values(slice(x, x_layout)?, slice(y, y_layout)?);
        made(sum, x_layout.shape().clone())
    }

    fn bwd(
        &self,
        _: &Tensor,
        _: &Tensor,
        result: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>)> {
        let through = with_slices([result, &grad.contiguous()?], |[r, g]| where_positive(r, g))?;
        let through = Tensor::from_vec(through, grad.shape(), grad.device())?;
        Ok((Some(through.clone()), Some(through)))
    }
}
