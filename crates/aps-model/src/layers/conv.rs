//! Convolution layers.

use std::sync::Arc;

use candle_core::{Module, Result, Tensor};
use candle_nn::{Init, VarBuilder};

use crate::ops::{self, ConvTensors};
use crate::parameters::{fan_in, kaiming_fan_out, normal};

/// PyTorch's `Conv2d` with a square kernel: `weight` (out, in, kernel, kernel), and `bias` (out) where there is one. It maps
/// (batch, in, height, width) to (batch, out, height', width').
#[derive(Debug, Clone)]
pub(crate) struct Conv2d(ConvTensors);

impl Conv2d {
    /// Creates a layer with a bias and PyTorch's initial weights; the size stays (odd kernels).
    pub fn same(inputs: usize, outputs: usize, kernel: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let init = fan_in(inputs * kernel * kernel);
        let weight = vb.get_with_hints((outputs, inputs, kernel, kernel), "weight", init)?;
        let bias = vb.get_with_hints(outputs, "bias", init)?;
        Self::new(weight, Some(bias), 1, kernel / 2)
    }

    /// Creates a layer as in torchvision's ResNets: no bias, padding of half the kernel, [`kaiming_fan_out`].
    pub fn residual(
        inputs: usize,
        outputs: usize,
        kernel: usize,
        stride: usize,
        vb: VarBuilder<'_>,
    ) -> Result<Self> {
        let init = kaiming_fan_out(outputs * kernel * kernel);
        let weight = vb.get_with_hints((outputs, inputs, kernel, kernel), "weight", init)?;
        Self::new(weight, None, stride, kernel / 2)
    }

    /// Creates a layer as in torchvision's vision transformers: one output pixel a patch, weights of variance 1 / fan_in,
    /// bias 0.
    ///
    /// torchvision cuts the normal distribution at ±2, which is beyond 50 standard deviations.
    pub fn patches(
        inputs: usize,
        outputs: usize,
        patch: usize,
        vb: VarBuilder<'_>,
    ) -> Result<Self> {
        let init = normal(1.0 / ((inputs * patch * patch) as f64).sqrt());
        let weight = vb.get_with_hints((outputs, inputs, patch, patch), "weight", init)?;
        let bias = vb.get_with_hints(outputs, "bias", Init::Const(0.0))?;
        Self::new(weight, Some(bias), patch, 0)
    }

    fn new(weight: Tensor, bias: Option<Tensor>, stride: usize, padding: usize) -> Result<Self> {
        // A weight that nothing asks a gradient of is a constant. The layer takes a copy, which nobody else can change, so
        // that the cached kernels stay those of the weight.
        let (weight, cache) = match weight.track_op() {
            true => (weight, None),
            false => (weight.copy()?, Some(Arc::default())),
        };
        Ok(Self(ConvTensors {
            weight,
            bias,
            stride,
            padding: (padding, padding),
            cache,
        }))
    }

    pub fn tensors(&self) -> &ConvTensors {
        &self.0
    }
}

impl Module for Conv2d {
    fn forward(&self, x: &Tensor) -> Result<Tensor> {
        let t = &self.0;
        ops::conv2d(x, &t.weight, t.bias.as_ref(), t.stride, t.padding)
    }
}

/// PyTorch's `Conv1d` with an odd kernel that keeps the length: `weight` (out, in, kernel), `bias` (out). It maps (batch, in,
/// length) to (batch, out, length).
#[derive(Debug, Clone)]
pub(crate) struct Conv1d {
    weight: Tensor,
    bias: Tensor,
    padding: usize,
}

impl Conv1d {
    /// Creates a layer with PyTorch's initial weights.
    pub fn same(inputs: usize, outputs: usize, kernel: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let init = fan_in(inputs * kernel);
        Ok(Self {
            weight: vb.get_with_hints((outputs, inputs, kernel), "weight", init)?,
            bias: vb.get_with_hints(outputs, "bias", init)?,
            padding: kernel / 2,
        })
    }
}

impl Module for Conv1d {
    fn forward(&self, x: &Tensor) -> Result<Tensor> {
        ops::conv1d(x, &self.weight, &self.bias, self.padding)
    }
}

/// PyTorch's `ConvTranspose2d(kernel_size=2, stride=2)`: `weight` (in, out, 2, 2), `bias` (out). It maps (batch, in, height,
/// width) to (batch, out, 2 height, 2 width).
#[derive(Debug, Clone)]
pub(crate) struct ConvTranspose2x2 {
    weight: Tensor,
    bias: Tensor,
}

impl ConvTranspose2x2 {
    /// Creates a layer with PyTorch's initial weights, whose fan-in counts the weight's second dimension: the outputs.
    pub fn new(inputs: usize, outputs: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let init = fan_in(outputs * 4);
        Ok(Self {
            weight: vb.get_with_hints((inputs, outputs, 2, 2), "weight", init)?,
            bias: vb.get_with_hints(outputs, "bias", init)?,
        })
    }
}

impl Module for ConvTranspose2x2 {
    fn forward(&self, x: &Tensor) -> Result<Tensor> {
        ops::conv_transpose2x2(x, &self.weight, &self.bias)
    }
}
