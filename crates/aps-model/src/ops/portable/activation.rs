//! Functions applied to each element, and softmax.

use candle_core::{D, Result, Tensor};

use super::norm::at_least_f32;

/// max(x, 0), NaN where x is NaN. The gradient at 0 is 0, as in PyTorch.
pub(crate) fn relu(x: &Tensor) -> Result<Tensor> {
    let zeros = x.zeros_like()?;
    x.le(&zeros)?.where_cond(&zeros, x)
}

/// x where it is positive, else `slope` times x. The gradient at 0 is `slope`, as in PyTorch.
pub(crate) fn leaky_relu(x: &Tensor, slope: f64) -> Result<Tensor> {
    let positive = x.gt(&x.zeros_like()?)?;
    positive.where_cond(x, &(x * slope)?)
}

/// The exact Gaussian error linear unit x Φ(x), Φ the normal distribution function (Hendrycks and Gimpel,
/// arXiv:1606.08415). Half precision is computed in f32: 1 + erf of a negative number takes digits away.
pub(crate) fn gelu(x: &Tensor) -> Result<Tensor> {
    let single = at_least_f32(x)?;
    let twice_phi = ((&single * std::f64::consts::FRAC_1_SQRT_2)?.erf()? + 1.0)?;
    ((single * 0.5)? * twice_phi)?.to_dtype(x.dtype())
}

/// The largest value along the last dimension, which is kept with length 1. Equal ones share the gradient, as in PyTorch.
pub(crate) fn max_last(x: &Tensor) -> Result<Tensor> {
    // candle's own gives each of them the whole gradient.
    let top = x.detach().max_keepdim(D::Minus1)?;
    let is_top = x.detach().broadcast_eq(&top)?.to_dtype(x.dtype())?;
    let share = is_top.broadcast_div(&is_top.sum_keepdim(D::Minus1)?)?;
    (x * share)?.sum_keepdim(D::Minus1)
}

/// exp(x) over its sum, along the last dimension.
pub(crate) fn softmax_last(x: &Tensor) -> Result<Tensor> {
    // Any constant may be subtracted: it needs no gradient.
    let top = x.detach().max_keepdim(D::Minus1)?;
    let exp = at_least_f32(&x.broadcast_sub(&top)?)?.exp()?;
    let shares = exp.broadcast_div(&exp.sum_keepdim(D::Minus1)?)?;
    shares.to_dtype(x.dtype())
}
