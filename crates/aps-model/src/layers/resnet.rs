//! ResNet-18 (He et al., CVPR 2016) as in torchvision, without its classifier.

use candle_core::{ModuleT, Result, Tensor};
use candle_nn::VarBuilder;

use super::{Conv2d, NormedConv};
use crate::ops::{self, Activation};

/// Two 3 x 3 convolutions beside a shortcut: `conv1`, `bn1`, `conv2`, `bn2`, `downsample.0` and `.1`.
#[derive(Debug, Clone)]
struct BasicBlock {
    first: NormedConv,
    second: NormedConv,
    /// A 1 x 1 convolution where size or channels change.
    downsample: Option<NormedConv>,
}

impl BasicBlock {
    fn new(inputs: usize, outputs: usize, stride: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let normed = |conv: &str, norm: &str, inputs, kernel, stride| {
            let conv = Conv2d::residual(inputs, outputs, kernel, stride, vb.pp(conv))?;
            NormedConv::new(conv, outputs, vb.pp(norm))
        };
        let is_changed = stride != 1 || inputs != outputs;
        let downsample = || normed("downsample.0", "downsample.1", inputs, 1, stride);
        Ok(Self {
            first: normed("conv1", "bn1", inputs, 3, stride)?,
            second: normed("conv2", "bn2", outputs, 3, 1)?,
            downsample: is_changed.then(downsample).transpose()?,
        })
    }
}

impl ModuleT for BasicBlock {
    fn forward_t(&self, x: &Tensor, train: bool) -> Result<Tensor> {
        let y = self.first.forward_t(x, Activation::Relu, train)?;
        let shortcut = match &self.downsample {
            None => x.clone(),
            Some(downsample) => downsample.forward_t(x, Activation::Identity, train)?,
        };
        self.second
            .forward_t(&y, Activation::AddRelu(&shortcut), train)
    }
}

/// The first layers: 7 x 7 convolution with stride 2, batch normalisation, ReLU, maximum over 3 x 3 with stride 2.
#[derive(Debug, Clone)]
pub(super) struct Stem(NormedConv);

impl Stem {
    pub fn new(width: usize, conv: VarBuilder<'_>, norm: VarBuilder<'_>) -> Result<Self> {
        let conv = Conv2d::residual(3, width, 7, 2, conv)?;
        Ok(Self(NormedConv::new(conv, width, norm)?))
    }
}

impl ModuleT for Stem {
    fn forward_t(&self, images: &Tensor, train: bool) -> Result<Tensor> {
        ops::max_pool_3x3_s2_p1(&self.0.forward_t(images, Activation::Relu, train)?)
    }
}

/// One of ResNet-18's four stages: two blocks, `0` and `1`. All but the first stage halve the size in their first block. It
/// maps features (batch, inputs, height, width) to features (batch, outputs, ...).
#[derive(Debug, Clone)]
pub(super) struct Stage([BasicBlock; 2]);

impl Stage {
    /// Creates `layer1` to `layer4`, with width, 2, 4 and 8 times width channels.
    pub fn all_four(width: usize, vb: &VarBuilder<'_>) -> Result<Vec<Self>> {
        let stage = |n: usize| {
            let (inputs, outputs) = (width << n.saturating_sub(1), width << n);
            let vb = vb.pp(format!("layer{}", n + 1));
            let stride = if n == 0 { 1 } else { 2 };
            Ok(Self([
                BasicBlock::new(inputs, outputs, stride, vb.pp(0))?,
                BasicBlock::new(outputs, outputs, 1, vb.pp(1))?,
            ]))
        };
        (0..4).map(stage).collect()
    }
}

impl ModuleT for Stage {
    fn forward_t(&self, x: &Tensor, train: bool) -> Result<Tensor> {
        self.0[1].forward_t(&self.0[0].forward_t(x, train)?, train)
    }
}

/// ResNet-18 up to its global mean: `conv1`, `bn1`, `layer1` to `layer4`. It maps images (batch, 3, height, width) to features
/// (batch, 8 width).
#[derive(Debug, Clone)]
pub(crate) struct ResNet18 {
    stem: Stem,
    stages: Vec<Stage>,
}

impl ResNet18 {
    /// Creates a network with `width` channels in the first stage; 64 is ResNet-18 itself.
    pub fn new(width: usize, vb: VarBuilder<'_>) -> Result<Self> {
        Ok(Self {
            stem: Stem::new(width, vb.pp("conv1"), vb.pp("bn1"))?,
            stages: Stage::all_four(width, &vb)?,
        })
    }
}

impl ModuleT for ResNet18 {
    fn forward_t(&self, images: &Tensor, train: bool) -> Result<Tensor> {
        let mut x = self.stem.forward_t(images, train)?;
        for stage in &self.stages {
            x = stage.forward_t(&x, train)?;
        }
        ops::flatten_from(&ops::adaptive_avg_pool(&x, 1)?, 1)
    }
}
