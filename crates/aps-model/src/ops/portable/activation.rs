//! Functions applied to each element, and softmax.

use candle_core::{D, Result, Tensor};

/// max(x, 0). The gradient at 0 is 0, as in PyTorch.
pub(crate) fn relu(x: &Tensor) -> Result<Tensor> {
    let zeros = x.zeros_like()?;
    x.gt(&zeros)?.where_cond(x, &zeros)
}

/// x where it is positive, else `slope` times x. The gradient at 0 is `slope`, as in PyTorch.
pub(crate) fn leaky_relu(x: &Tensor, slope: f64) -> Result<Tensor> {
    let positive = x.gt(&x.zeros_like()?)?;
    positive.where_cond(x, &(x * slope)?)
}

/// The exact Gaussian error linear unit x Φ(x), Φ the normal distribution function (Hendrycks and Gimpel,
/// arXiv:1606.08415).
pub(crate) fn gelu(x: &Tensor) -> Result<Tensor> {
    let twice_phi = ((x * std::f64::consts::FRAC_1_SQRT_2)?.erf()? + 1.0)?;
    (x * 0.5)? * twice_phi
}

/// exp(x) over its sum, along the last dimension.
pub(crate) fn softmax_last(x: &Tensor) -> Result<Tensor> {
    // Any constant may be subtracted: it needs no gradient.
    let top = x.detach().max_keepdim(D::Minus1)?;
    let exp = x.broadcast_sub(&top)?.exp()?;
    exp.broadcast_div(&exp.sum_keepdim(D::Minus1)?)
}
