//! The affine map.

use candle_core::{Result, Tensor};

/// x Wᵀ + b over the last dimension: (..., in) to (..., out), with a weight (out, in) and a bias (out).
///
/// Weight and bias take the type of `x`, so that half-precision inputs are computed in half precision.
pub(crate) fn linear(x: &Tensor, weight: &Tensor, bias: &Tensor) -> Result<Tensor> {
    let (out, inputs) = weight.dims2()?;
    let weight = weight.to_dtype(x.dtype())?;
    let bias = bias.to_dtype(x.dtype())?;
    let mut dims = x.dims().to_vec();
    // One product over all rows: a batched one would copy the weight for each.
    let rows = x.contiguous()?.reshape(((), inputs))?;
    let y = rows.matmul(&weight.t()?)?.broadcast_add(&bias)?;
    if let Some(last) = dims.last_mut() {
        *last = out;
    }
    y.reshape(dims)
}
