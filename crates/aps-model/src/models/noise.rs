//! The noise input that the adversarially trained predictors keep from their generative origin.

use candle_core::Tensor;

use crate::layers::Linear;
use crate::{Result, Scope};

/// `noise_proj`, fed zeros: the predictors are deterministic. Only its bias has an effect, and only it is trained.
#[derive(Debug, Clone)]
pub(super) struct NoiseInput {
    projection: Linear,
    size: usize,
}

impl NoiseInput {
    /// Creates the projection from 2 width to 4 width values.
    pub(super) fn new(scope: &Scope, width: usize) -> Result<Self> {
        Ok(Self {
            projection: Linear::new(&scope.at("noise_proj"), 2 * width, 4 * width)?,
            size: 2 * width,
        })
    }

    /// Puts the projected zeros after `features` (batch, n): (batch, n + 4 width).
    pub(super) fn append(&self, features: &Tensor) -> Result<Tensor> {
        let zeros = Tensor::zeros(
            (features.dim(0)?, self.size),
            features.dtype(),
            features.device(),
        )?;
        Ok(Tensor::cat(
            &[features, &self.projection.forward(&zeros)?],
            1,
        )?)
    }
}
