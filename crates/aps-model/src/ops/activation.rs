//! Activations on the CPU, each in one pass forward and one backward.

use candle_core::{CpuStorage, CustomOp1, CustomOp2, Layout, Result, Shape, Tensor};

use super::storage::{are_fast, made, slice, with_slices};
use crate::kernels::{gelu as kernel, rectifier};
use crate::portable;

/// [`portable::gelu`].
pub fn gelu(x: &Tensor) -> crate::Result<Tensor> {
    match are_fast(&[x]) {
        true => Ok(x.contiguous()?.apply_op1(Gelu)?),
        false => portable::gelu(x),
    }
}

/// [`portable::leaky_relu`].
pub fn leaky_relu(x: &Tensor, slope: f64) -> crate::Result<Tensor> {
    match are_fast(&[x]) {
        true => Ok(x.contiguous()?.apply_op1(LeakyRelu(slope as f32))?),
        false => portable::leaky_relu(x, slope),
    }
}

/// `relu(x + y)`, the end of a residual block, for tensors of the same shape.
pub fn add_relu(x: &Tensor, y: &Tensor) -> crate::Result<Tensor> {
    if !are_fast(&[x, y]) || x.dims() != y.dims() {
        return portable::relu(&(x + y)?);
    }
    Ok(x.contiguous()?.apply_op2(&y.contiguous()?, AddRelu)?)
}

struct Gelu;

impl CustomOp1 for Gelu {
    fn name(&self) -> &'static str {
        "gelu"
    }

    fn cpu_fwd(&self, x: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        made(kernel::gelu(slice(x, layout)?), layout.shape().clone())
    }

    fn bwd(&self, x: &Tensor, _: &Tensor, grad: &Tensor) -> Result<Option<Tensor>> {
        let through = with_slices([x, &grad.contiguous()?], |[x, g]| {
            kernel::gelu_gradient(x, g)
        })?;
        Tensor::from_vec(through, x.shape(), x.device()).map(Some)
    }
}

struct LeakyRelu(f32);

impl CustomOp1 for LeakyRelu {
    fn name(&self) -> &'static str {
        "leaky_relu"
    }

    fn cpu_fwd(&self, x: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        let y = rectifier::leaky(slice(x, layout)?, self.0);
        made(y, layout.shape().clone())
    }

    fn bwd(&self, x: &Tensor, _: &Tensor, grad: &Tensor) -> Result<Option<Tensor>> {
        let through = with_slices([x, &grad.contiguous()?], |[x, g]| {
            rectifier::leaky_gradient(x, g, self.0)
        })?;
        Tensor::from_vec(through, x.shape(), x.device()).map(Some)
    }
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
        let sum = rectifier::add_relu(slice(x, x_layout)?, slice(y, y_layout)?);
        made(sum, x_layout.shape().clone())
    }

    fn bwd(
        &self,
        _: &Tensor,
        _: &Tensor,
        result: &Tensor,
        grad: &Tensor,
    ) -> Result<(Option<Tensor>, Option<Tensor>)> {
        let through = with_slices([result, &grad.contiguous()?], |[r, g]| {
            rectifier::where_positive(r, g)
        })?;
        let through = Tensor::from_vec(through, grad.shape(), grad.device())?;
        Ok((Some(through.clone()), Some(through)))
    }
}
