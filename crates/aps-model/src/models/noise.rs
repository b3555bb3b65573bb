//! The noise input that the adversarially trained predictors keep from their generative origin.

use candle_core::{Module, Result, Tensor};
use candle_nn::VarBuilder;

use crate::layers::Linear;
use crate::ops;

/// `noise_proj`, fed zeros: the predictors are deterministic. Only its bias has an effect, and only it is trained.
#[derive(Debug, Clone)]
pub(super) struct NoiseInput {
    projection: Linear,
    size: usize,
}

impl NoiseInput {
    /// Creates the projection from 2 width to 4 width values.
    pub fn new(width: usize, vb: &VarBuilder<'_>) -> Result<Self> {
        Ok(Self {
            projection: Linear::new(2 * width, 4 * width, vb.pp("noise_proj"))?,
            size: 2 * width,
        })
    }

    /// Puts the projected zeros after `features` (batch, n): (batch, n + 4 width).
    pub fn append(&self, features: &Tensor) -> Result<Tensor> {
        let zeros = ops::zeros(self.size, features)?;
        ops::cat(&[features, &self.projection.forward(&zeros)?], 1)
    }
}
