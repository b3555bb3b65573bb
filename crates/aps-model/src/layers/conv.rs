//! Convolution layers.

use std::sync::Arc;

use candle_core::Tensor;

use crate::{Init, Result, Scope, ops};

/// PyTorch's `Conv2d` with a square kernel: `weight` (out, in, kernel, kernel), and `bias` (out) where there is one.
#[derive(Debug, Clone)]
pub struct Conv2d {
    weight: Tensor,
    bias: Option<Tensor>,
    stride: usize,
    padding: usize,
    kept: Option<Arc<ops::Kept>>,
}

/// Returns an empty kernel cache for a layer over frozen parameters; `None` for any other.
fn kept(scope: &Scope) -> Option<Arc<ops::Kept>> {
    scope.is_frozen().then(Arc::default)
}

impl Conv2d {
    /// Creates a layer with a bias and PyTorch's initial weights; the size stays (odd kernels).
    pub fn same(scope: &Scope, inputs: usize, outputs: usize, kernel: usize) -> Result<Self> {
        let init = Init::fan_in(inputs * kernel * kernel);
        Ok(Self {
            weight: scope.trainable("weight", (outputs, inputs, kernel, kernel), init)?,
            bias: Some(scope.trainable("bias", outputs, init)?),
            stride: 1,
            padding: kernel / 2,
            kept: kept(scope),
        })
    }

    /// Creates a layer as in torchvision's ResNets: no bias, padding of half the kernel, [`Init::kaiming_fan_out`].
    pub fn residual(
        scope: &Scope,
        inputs: usize,
        outputs: usize,
        kernel: usize,
        stride: usize,
    ) -> Result<Self> {
        let init = Init::kaiming_fan_out(outputs * kernel * kernel);
        Ok(Self {
            weight: scope.trainable("weight", (outputs, inputs, kernel, kernel), init)?,
            bias: None,
            stride,
            padding: kernel / 2,
            kept: kept(scope),
        })
    }

    /// Creates a layer as in torchvision's vision transformers: one output pixel a patch, weights of variance 1 / fan_in,
    /// bias 0.
    ///
    /// torchvision cuts the normal distribution at ±2, which is beyond 50 standard deviations.
    pub fn patches(scope: &Scope, inputs: usize, outputs: usize, patch: usize) -> Result<Self> {
        let std = 1.0 / ((inputs * patch * patch) as f64).sqrt();
        Ok(Self {
            weight: scope.trainable(
                "weight",
                (outputs, inputs, patch, patch),
                Init::Normal { std },
            )?,
            bias: Some(scope.trainable("bias", outputs, Init::ZEROS)?),
            stride: patch,
            padding: 0,
            kept: kept(scope),
        })
    }

    /// Maps `x` (batch, in, height, width) to (batch, out, height', width').
    pub fn forward(&self, x: &Tensor) -> Result<Tensor> {
        let t = self.tensors();
        ops::conv2d(x, t.weight, t.bias, t.stride, t.padding)
    }

    pub(super) fn tensors(&self) -> ops::ConvTensors<'_> {
        ops::ConvTensors {
            weight: &self.weight,
            bias: self.bias.as_ref(),
            stride: self.stride,
            padding: (self.padding, self.padding),
            kept: self.kept.as_deref(),
        }
    }
}

/// PyTorch's `Conv1d` with an odd kernel that keeps the length: `weight` (out, in, kernel), `bias` (out).
#[derive(Debug, Clone)]
pub struct Conv1d {
    weight: Tensor,
    bias: Tensor,
    padding: usize,
}

impl Conv1d {
    /// Creates a layer with PyTorch's initial weights.
    pub fn same(scope: &Scope, inputs: usize, outputs: usize, kernel: usize) -> Result<Self> {
        let init = Init::fan_in(inputs * kernel);
        Ok(Self {
            weight: scope.trainable("weight", (outputs, inputs, kernel), init)?,
            bias: scope.trainable("bias", outputs, init)?,
            padding: kernel / 2,
        })
    }

    /// Maps `x` (batch, in, length) to (batch, out, length).
    pub fn forward(&self, x: &Tensor) -> Result<Tensor> {
        // A line is an image of height 1.
        let x = x.unsqueeze(2)?;
        let weight = self.weight.unsqueeze(2)?;
        let y = ops::conv2d(&x, &weight, Some(&self.bias), 1, (0, self.padding))?;
        Ok(y.squeeze(2)?)
    }
}

/// PyTorch's `ConvTranspose2d(kernel_size=2, stride=2)`: `weight` (in, out, 2, 2), `bias` (out).
#[derive(Debug, Clone)]
pub struct ConvTranspose2x2 {
    weight: Tensor,
    bias: Tensor,
}

impl ConvTranspose2x2 {
    /// Creates a layer with PyTorch's initial weights, whose fan-in counts the weight's second dimension: the outputs.
    pub fn new(scope: &Scope, inputs: usize, outputs: usize) -> Result<Self> {
        let init = Init::fan_in(outputs * 4);
        Ok(Self {
            weight: scope.trainable("weight", (inputs, outputs, 2, 2), init)?,
            bias: scope.trainable("bias", outputs, init)?,
        })
    }

    /// Maps `x` (batch, in, height, width) to (batch, out, 2 height, 2 width).
    pub fn forward(&self, x: &Tensor) -> Result<Tensor> {
        ops::conv_transpose2x2(x, &self.weight, Some(&self.bias))
    }
}
