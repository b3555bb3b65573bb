//! Max pooling on the CPU.

use candle_core::{CpuStorage, CustomOp1, Layout, Result, Shape, Tensor};

use super::storage::{are_fast, made, slice, with_slices};
use crate::kernels::ConvShape;
use crate::kernels::max_pool::{max_pool, max_pool_gradient};
use crate::portable;

/// [`portable::max_pool_2x2`].
pub fn max_pool_2x2(x: &Tensor) -> crate::Result<Tensor> {
    match fast(x, 2, 0)? {
        Some(y) => Ok(y),
        None => portable::max_pool_2x2(x),
    }
}

/// [`portable::max_pool_3x3_s2_p1`].
pub fn max_pool_3x3_s2_p1(x: &Tensor) -> crate::Result<Tensor> {
    match fast(x, 3, 1)? {
        Some(y) => Ok(y),
        None => portable::max_pool_3x3_s2_p1(x),
    }
}

fn fast(x: &Tensor, kernel: usize, padding: usize) -> crate::Result<Option<Tensor>> {
    let Ok((batch, channels, height, width)) = x.dims4() else {
        return Ok(None);
    };
    let windows = ConvShape {
        batch,
        in_channels: channels,
        height,
        width,
        out_channels: channels,
        kernel: (kernel, kernel),
        stride: 2,
        padding: (padding, padding),
    };
    if !are_fast(&[x]) || !windows.is_valid() {
        return Ok(None);
    }
    Ok(Some(x.contiguous()?.apply_op1(MaxPool(windows))?))
}

struct MaxPool(ConvShape);

impl CustomOp1 for MaxPool {
    fn name(&self) -> &'static str {
        "max_pool2d"
    }

    fn cpu_fwd(&self, x: &CpuStorage, layout: &Layout) -> Result<(CpuStorage, Shape)> {
        let s = &self.0;
        let y = max_pool(s, slice(x, layout)?);
        made(y, (s.batch, s.in_channels, s.out_height(), s.out_width()))
    }

    fn bwd(&self, x: &Tensor, _: &Tensor, grad: &Tensor) -> Result<Option<Tensor>> {
        let grad = grad.contiguous()?;
        let by_input = with_slices([x, &grad], |[x, g]| max_pool_gradient(&self.0, x, g))?;
        Ok(Some(Tensor::from_vec(by_input, x.shape(), x.device())?))
    }
}
