//! The affine map.

use candle_core::{Result, Tensor};

use super::norm::at_least_f32;

/// x Wᵀ + b over the last dimension: (..., in) to (..., out), with a weight (out, in) and a bias (out).
///
/// The weight takes the type of `x`, so that half-precision inputs are multiplied in half precision; the bias is added, and its
/// gradient summed, in f32.
pub(crate) fn linear(x: &Tensor, weight: &Tensor, bias: &Tensor) -> Result<Tensor> {
    let (out, inputs) = weight.dims2()?;
    let weight = weight.to_dtype(x.dtype())?;
    let mut dims = x.dims().to_vec();
    // One product over all rows: a batched one would copy the weight for each.
    let rows = x.contiguous()?.reshape(((), inputs))?;
    let y = at_least_f32(&rows.matmul(&weight.t()?)?)?;
    let y = y.broadcast_add(&bias.to_dtype(y.dtype())?)?;
    if let Some(last) = dims.last_mut() {
        *last = out;
    }
    y.to_dtype(x.dtype())?.reshape(dims)
}
