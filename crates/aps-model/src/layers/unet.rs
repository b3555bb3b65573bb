//! The block of a U-Net.

use candle_core::Tensor;

use super::{BatchNorm, Conv2d, NormedConv};
use crate::ops::After;
use crate::{Mode, Result, Scope};

/// Twice a 3 x 3 convolution, batch normalisation and ReLU: `block.0`, `block.1`, `block.3`, `block.4`.
#[derive(Debug, Clone)]
pub struct DoubleConv {
    first: NormedConv,
    second: NormedConv,
}

impl DoubleConv {
    /// Creates a block from `inputs` to `outputs` channels; the size stays.
    pub fn new(scope: &Scope, inputs: usize, outputs: usize) -> Result<Self> {
        let block = scope.at("block");
        let half = |at: usize, inputs| -> Result<_> {
            let conv = Conv2d::same(&block.at(at), inputs, outputs, 3)?;
            let norm = BatchNorm::new(&block.at(at + 1), outputs)?;
            Ok(NormedConv::new(conv, norm))
        };
        Ok(Self {
            first: half(0, inputs)?,
            second: half(3, outputs)?,
        })
    }

    /// Maps `x` (batch, inputs, height, width) to (batch, outputs, height, width).
    pub fn forward(&self, x: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        let x = self.first.forward(x, After::Relu, mode)?;
        self.second.forward(&x, After::Relu, mode)
    }
}
