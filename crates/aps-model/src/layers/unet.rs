//! The block of a U-Net.

use candle_core::{ModuleT, Result, Tensor};
use candle_nn::VarBuilder;

use super::{Conv2d, NormedConv};
use crate::ops::Activation;

/// Twice a 3 x 3 convolution, batch normalisation and ReLU: `block.0`, `block.1`, `block.3`, `block.4`. It maps (batch,
/// inputs, height, width) to (batch, outputs, height, width).
#[derive(Debug, Clone)]
pub(crate) struct DoubleConv([NormedConv; 2]);

impl DoubleConv {
    pub fn new(inputs: usize, outputs: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let block = vb.pp("block");
        let half = |at: usize, inputs| {
            let conv = Conv2d::same(inputs, outputs, 3, block.pp(at))?;
            NormedConv::new(conv, outputs, block.pp(at + 1))
        };
        Ok(Self([half(0, inputs)?, half(3, outputs)?]))
    }
}

impl ModuleT for DoubleConv {
    fn forward_t(&self, x: &Tensor, train: bool) -> Result<Tensor> {
        let x = self.0[0].forward_t(x, Activation::Relu, train)?;
        self.0[1].forward_t(&x, Activation::Relu, train)
    }
}
