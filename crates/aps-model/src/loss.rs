//! Losses. Each is the mean over all values of a batch.

use candle_core::{D, Result, Tensor};

/// Loss of a model's training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Loss {
    /// Mean squared error.
    Squared,
    /// Mean absolute error, beside the score of a [`Regularizer`](crate::Regularizer).
    Adversarial,
    /// Mean absolute error, and 1 less the cosine of the angle between prediction and target, averaged over the links.
    AbsoluteAndCosine,
}

impl Loss {
    /// Computes the error of predictions, of the shape (links, bins) of their targets; without the regularizer's part.
    pub(crate) fn error(self, prediction: &Tensor, target: &Tensor) -> Result<Tensor> {
        match self {
            Self::Squared => candle_nn::loss::mse(prediction, target),
            Self::Adversarial => l1(prediction, target),
            Self::AbsoluteAndCosine => {
                l1(prediction, target)? + (1.0 - cosine(prediction, target)?)?
            }
        }
    }
}

/// Keeps the root of the product of two spectra's energies above 0.
const LEAST_ENERGY: f64 = 1e-12;

/// Computes the cosine of the angle between the rows of two tensors, averaged over the rows.
fn cosine(a: &Tensor, b: &Tensor) -> Result<Tensor> {
    let energy = (a.sqr()?.sum(D::Minus1)? * b.sqr()?.sum(D::Minus1)?)?;
    let product = (a * b)?.sum(D::Minus1)?;
    (product / (energy + LEAST_ENERGY)?.sqrt()?)?.mean_all()
}

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
