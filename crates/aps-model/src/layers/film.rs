//! Feature-wise modulation by a condition.

use candle_core::{Module, Result, Tensor};
use candle_nn::VarBuilder;

use super::Linear;

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
        let scale_and_shift = self.proj.forward(condition)?.unsqueeze(2)?;
        let channels = x.dim(1)?;
        let scale = scale_and_shift.narrow(1, 0, channels)?;
        let shift = scale_and_shift.narrow(1, channels, channels)?;
        x.broadcast_mul(&scale)?.broadcast_add(&shift)
    }
}
