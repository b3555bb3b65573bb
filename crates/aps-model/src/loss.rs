//! Losses beside those of [`candle_nn::loss`]. Each is the mean over all values of a batch.

use candle_core::{Result, Tensor};

/// Computes the mean absolute error of tensors of one shape. Where both are equal its gradient is 0, as PyTorch's.
pub(crate) fn l1(prediction: &Tensor, target: &Tensor) -> Result<Tensor> {
    let difference = (prediction - target)?;
    // Not abs(): candle gives it the slope 1 at 0.
    let sign = difference.detach().sign()?;
    (difference * sign)?.mean_all()
}

/// Computes the binary cross-entropy of scores before the sigmoid (logits) against targets in \[0, 1\], of one shape.
///
/// max(x, 0) - x t + ln(1 + e^-|x|), which is finite for every finite logit, with its gradient sigmoid(x) - t. The
/// logarithm rounds to 0 where |x| > 17; the gradient does not.
/// candle's own takes the logarithm of the sigmoid, which is infinite for large logits.
pub(crate) fn bce_with_logits(logits: &Tensor, target: &Tensor) -> Result<Tensor> {
    let rest = (logits.abs()?.neg()?.exp()? + 1.0)?.log()?;
    let linear = (logits.relu()? - (logits * target)?)?;
    (linear + rest)?.mean_all()
}
