//! Batch normalisation.

use candle_core::{Tensor, Var};

use crate::{Init, Mode, Result, Scope, ops};

/// PyTorch's `BatchNorm1d` and `BatchNorm2d`: `weight`, `bias`, `running_mean`, `running_var` (channels) and the counter
/// `num_batches_tracked`.
#[derive(Debug, Clone)]
pub struct BatchNorm {
    weight: Tensor,
    bias: Tensor,
    running_mean: Var,
    running_var: Var,
    passes: Var,
}

impl BatchNorm {
    /// Creates a layer that is the identity at first: weight and variance 1, bias and mean 0.
    pub fn new(scope: &Scope, channels: usize) -> Result<Self> {
        Ok(Self {
            weight: scope.trainable("weight", channels, Init::ONES)?,
            bias: scope.trainable("bias", channels, Init::ZEROS)?,
            running_mean: scope.buffer("running_mean", channels, Init::ZEROS)?,
            running_var: scope.buffer("running_var", channels, Init::ONES)?,
            passes: scope.counter("num_batches_tracked")?,
        })
    }

    /// Normalises `x` (batch, channels, ...); see [`ops::batch_norm`].
    pub fn forward(&self, x: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        self.count(mode)?;
        ops::batch_norm(x, self.tensors(), mode)
    }

    /// Normalises `x` and applies ReLU.
    pub fn forward_relu(&self, x: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        self.count(mode)?;
        ops::batch_norm_relu(x, self.tensors(), mode)
    }

    /// Counts a training pass.
    pub(super) fn count(&self, mode: Mode<'_>) -> Result<()> {
        if mode.is_training() {
            let next = (self.passes.as_detached_tensor() + 1.0)?;
            self.passes.set(&next)?;
        }
        Ok(())
    }

    pub(super) fn tensors(&self) -> ops::BatchNormTensors<'_> {
        ops::BatchNormTensors {
            weight: &self.weight,
            bias: &self.bias,
            running_mean: &self.running_mean,
            running_var: &self.running_var,
        }
    }
}
