//! Feature-wise modulation by a condition.

use candle_core::{Module, Result, Tensor};
use candle_nn::VarBuilder;

use super::Linear;
use crate::ops;

/// FiLM (Perez et al., AAAI 2018): `proj` maps a condition to a scale and a shift a channel, all scales first.
#[derive(Debug, Clone)]
pub(crate) struct Film {
    proj: Linear,
}

impl Film {
    pub fn new(condition: usize, channels: usize, vb: VarBuilder<'_>) -> Result<Self> {
        Ok(Self {
            proj: Linear::new(condition, 2 * channels, vb.pp("proj"))?,
        })
    }

    /// Computes scale x + shift, for `x` (batch, channels, length) and `condition` (batch, features).
    pub fn forward(&self, x: &Tensor, condition: &Tensor) -> Result<Tensor> {
        let scale_and_shift = ops::unsqueeze(&self.proj.forward(condition)?, 2)?;
        let channels = x.dim(1)?;
        let scale = ops::narrow(&scale_and_shift, 1, 0, channels)?;
        let shift = ops::narrow(&scale_and_shift, 1, channels, channels)?;
        ops::add(&ops::mul(x, &scale)?, &shift)
    }
}
