//! Feature-wise modulation by a condition.

use candle_core::Tensor;

use super::Linear;
use crate::{Result, Scope};

/// FiLM (Perez et al., AAAI 2018): `proj` maps a condition to a scale and a shift a channel.
#[derive(Debug, Clone)]
pub struct Film {
    proj: Linear,
}

impl Film {
    /// Creates a layer; `proj` gives all scales first, then all shifts.
    pub fn new(scope: &Scope, condition: usize, channels: usize) -> Result<Self> {
        Ok(Self {
            proj: Linear::new(&scope.at("proj"), condition, 2 * channels)?,
        })
    }

    /// Computes gamma x + beta, for `x` (batch, channels, length) and `condition` (batch, features).
    pub fn forward(&self, x: &Tensor, condition: &Tensor) -> Result<Tensor> {
        let scale_and_shift = self.proj.forward(condition)?.unsqueeze(2)?;
        let channels = x.dim(1)?;
        let gamma = scale_and_shift.narrow(1, 0, channels)?;
        let beta = scale_and_shift.narrow(1, channels, channels)?;
        Ok(x.broadcast_mul(&gamma)?.broadcast_add(&beta)?)
    }
}
