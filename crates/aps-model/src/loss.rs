//! Losses that training minimises.
//!
//! Each loss is the mean over all values of a batch: a tensor without axes, to call
//! [`backward`](candle_core::Tensor::backward) on.

use candle_core::Tensor;

use crate::Result;

/// Mean squared error of tensors of one shape.
pub fn mse(prediction: &Tensor, target: &Tensor) -> Result<Tensor> {
    Ok((prediction - target)?.sqr()?.mean_all()?)
}

/// Mean absolute error of tensors of one shape. Where both are equal its gradient is 0, as PyTorch's.
pub fn l1(prediction: &Tensor, target: &Tensor) -> Result<Tensor> {
    let difference = (prediction - target)?;
    // Not abs(): candle gives it the slope 1 at 0.
    let sign = difference.detach().sign()?;
    Ok((difference * sign)?.mean_all()?)
}

/// Binary cross-entropy of scores before the sigmoid (logits) against targets in \[0, 1\], of one shape.
///
/// max(x, 0) - x t + ln(1 + e^-|x|), which is finite for every finite logit, with its gradient sigmoid(x) - t. The
/// logarithm rounds to 0 where |x| > 17; the gradient does not.
///
/// ```
/// use aps_model::{candle_core::{Device, Tensor}, loss};
/// let (logits, ones) = (Tensor::new(&[1e4_f32], &Device::Cpu)?, Tensor::new(&[1_f32], &Device::Cpu)?);
/// assert_eq!(loss::bce_with_logits(&logits, &ones)?.to_scalar::<f32>()?, 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn bce_with_logits(logits: &Tensor, target: &Tensor) -> Result<Tensor> {
    let rest = (logits.abs()?.neg()?.exp()? + 1.0)?.log()?;
    let linear = (logits.relu()? - (logits * target)?)?;
    Ok((linear + rest)?.mean_all()?)
}
