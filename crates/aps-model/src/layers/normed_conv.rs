//! A convolution and its batch normalisation.

use candle_core::{Result, Tensor};
use candle_nn::VarBuilder;

use super::{BatchNorm, Conv2d};
use crate::ops::{self, Activation};

/// A convolution, batch normalisation, and the activation after it: see [`ops::normed_conv2d`].
#[derive(Debug, Clone)]
pub(crate) struct NormedConv {
    conv: Conv2d,
    norm: BatchNorm,
}

impl NormedConv {
    /// Puts a new normalisation of `channels`, as many as `conv` makes, behind it.
    pub fn new(conv: Conv2d, channels: usize, norm: VarBuilder<'_>) -> Result<Self> {
        let norm = BatchNorm::new(channels, norm)?;
        Ok(Self { conv, norm })
    }

    /// Maps `x` (batch, in, height, width) to (batch, out, height', width').
    pub fn forward_t(&self, x: &Tensor, activation: Activation<'_>, train: bool) -> Result<Tensor> {
        self.norm.count(train)?;
        ops::normed_conv2d(
            x,
            self.conv.tensors(),
            self.norm.tensors(),
            activation,
            train,
        )
    }
}
