//! Fully connected layer.

use candle_core::Tensor;

use crate::{Init, Result, Scope, ops};

/// PyTorch's `Linear`: `weight` (out, in) and `bias` (out).
#[derive(Debug, Clone)]
pub struct Linear {
    weight: Tensor,
    bias: Tensor,
}

impl Linear {
    /// Creates a layer with PyTorch's initial weights.
    pub fn new(scope: &Scope, inputs: usize, outputs: usize) -> Result<Self> {
        Self::with_init(
            scope,
            inputs,
            outputs,
            Init::fan_in(inputs),
            Init::fan_in(inputs),
        )
    }

    /// Creates a layer with other initial weights.
    pub fn with_init(
        scope: &Scope,
        inputs: usize,
        outputs: usize,
        weight: Init,
        bias: Init,
    ) -> Result<Self> {
        Ok(Self {
            weight: scope.trainable("weight", (outputs, inputs), weight)?,
            bias: scope.trainable("bias", outputs, bias)?,
        })
    }

    /// Maps `x` (..., in) to (..., out).
    pub fn forward(&self, x: &Tensor) -> Result<Tensor> {
        ops::linear(x, &self.weight, &self.bias)
    }
}
