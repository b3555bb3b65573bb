//! Layer normalisation.

use candle_core::Tensor;

use crate::{Init, Result, Scope, ops};

/// PyTorch's `LayerNorm` over the last dimension, with torchvision's epsilon for vision transformers, 1e-6: `weight` and
/// `bias` (features).
#[derive(Debug, Clone)]
pub struct LayerNorm {
    weight: Tensor,
    bias: Tensor,
}

impl LayerNorm {
    /// Creates a layer with scale 1 and shift 0 at first.
    pub fn new(scope: &Scope, features: usize) -> Result<Self> {
        Ok(Self {
            weight: scope.trainable("weight", features, Init::ONES)?,
            bias: scope.trainable("bias", features, Init::ZEROS)?,
        })
    }

    /// Normalises `x` (..., features).
    pub fn forward(&self, x: &Tensor) -> Result<Tensor> {
        ops::layer_norm(x, &self.weight, &self.bias, 1e-6)
    }
}
