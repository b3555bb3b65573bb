//! The block of a U-Net.

use candle_core::Tensor;

use super::{BatchNorm, Conv2d};
use crate::{Mode, Result, Scope};

/// Twice a 3 x 3 convolution, batch normalisation and ReLU: `block.0`, `block.1`, `block.3`, `block.4`.
#[derive(Debug, Clone)]
pub struct DoubleConv {
    first: (Conv2d, BatchNorm),
    second: (Conv2d, BatchNorm),
}

impl DoubleConv {
    /// From `inputs` to `outputs` channels; the size stays.
    pub fn new(scope: &Scope, inputs: usize, outputs: usize) -> Result<Self> {
        let block = scope.at("block");
        let half = |at: usize, inputs| -> Result<_> {
            let conv = Conv2d::same(&block.at(at), inputs, outputs, 3)?;
            Ok((conv, BatchNorm::new(&block.at(at + 1), outputs)?))
        };
        Ok(Self {
            first: half(0, inputs)?,
            second: half(3, outputs)?,
        })
    }

    /// (batch, inputs, height, width) to (batch, outputs, height, width).
    pub fn forward(&self, x: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        let mut x = x.clone();
        for (conv, bn) in [&self.first, &self.second] {
            x = bn.forward_relu(&conv.forward(&x)?, mode)?;
        }
        Ok(x)
    }
}
