//! ResNet-18 (He et al., CVPR 2016) as in torchvision, without its classifier.

use candle_core::Tensor;

use super::{BatchNorm, Conv2d, NormedConv};
use crate::ops::After;
use crate::{Mode, Result, Scope, ops};

/// Two 3 x 3 convolutions beside a shortcut: `conv1`, `bn1`, `conv2`, `bn2`, `downsample.0` and `.1`.
#[derive(Debug, Clone)]
struct BasicBlock {
    first: NormedConv,
    second: NormedConv,
    /// A 1 x 1 convolution where size or channels change.
    downsample: Option<NormedConv>,
}

impl BasicBlock {
    fn new(scope: &Scope, inputs: usize, outputs: usize, stride: usize) -> Result<Self> {
        let normed = |conv: &Scope, norm: &Scope, inputs, kernel, stride| -> Result<_> {
            let conv = Conv2d::residual(conv, inputs, outputs, kernel, stride)?;
            Ok(NormedConv::new(conv, BatchNorm::new(norm, outputs)?))
        };
        let downsample = if stride != 1 || inputs != outputs {
            let scope = scope.at("downsample");
            Some(normed(&scope.at(0), &scope.at(1), inputs, 1, stride)?)
        } else {
            None
        };
        Ok(Self {
            first: normed(&scope.at("conv1"), &scope.at("bn1"), inputs, 3, stride)?,
            second: normed(&scope.at("conv2"), &scope.at("bn2"), outputs, 3, 1)?,
            downsample,
        })
    }

    fn forward(&self, x: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        let y = self.first.forward(x, After::Relu, mode)?;
        let shortcut = match &self.downsample {
            None => x.clone(),
            Some(downsample) => downsample.forward(x, After::Nothing, mode)?,
        };
        self.second.forward(&y, After::AddRelu(&shortcut), mode)
    }
}

/// The first layers: 7 x 7 convolution with stride 2, batch normalisation, ReLU, maximum over 3 x 3 with stride 2.
#[derive(Debug, Clone)]
pub(super) struct Stem(NormedConv);

impl Stem {
    pub(super) fn new(conv: &Scope, bn: &Scope, width: usize) -> Result<Self> {
        let conv = Conv2d::residual(conv, 3, width, 7, 2)?;
        Ok(Self(NormedConv::new(conv, BatchNorm::new(bn, width)?)))
    }

    pub(super) fn forward(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        ops::max_pool_3x3_s2_p1(&self.0.forward(images, After::Relu, mode)?)
    }
}

/// One of ResNet-18's four stages: two blocks, `0` and `1`. All but the first stage halve the size in their first block.
#[derive(Debug, Clone)]
pub struct Stage {
    blocks: [BasicBlock; 2],
}

impl Stage {
    fn new(scope: &Scope, inputs: usize, outputs: usize, stride: usize) -> Result<Self> {
        let first = BasicBlock::new(&scope.at(0), inputs, outputs, stride)?;
        let second = BasicBlock::new(&scope.at(1), outputs, outputs, 1)?;
        Ok(Self {
            blocks: [first, second],
        })
    }

    /// Creates `layer1` to `layer4` in `scope`, with width, 2, 4 and 8 times width channels.
    pub fn all_four(scope: &Scope, width: usize) -> Result<[Self; 4]> {
        let stage = |n: usize, inputs, outputs, stride| {
            Self::new(&scope.at(format!("layer{n}")), inputs, outputs, stride)
        };
        Ok([
            stage(1, width, width, 1)?,
            stage(2, width, 2 * width, 2)?,
            stage(3, 2 * width, 4 * width, 2)?,
            stage(4, 4 * width, 8 * width, 2)?,
        ])
    }

    /// Maps features (batch, inputs, height, width) to features (batch, outputs, ...).
    pub fn forward(&self, x: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        self.blocks
            .iter()
            .try_fold(x.clone(), |x, block| block.forward(&x, mode))
    }
}

/// ResNet-18 up to its global mean: `conv1`, `bn1`, `layer1` to `layer4`.
#[derive(Debug, Clone)]
pub struct ResNet18 {
    stem: Stem,
    stages: [Stage; 4],
}

impl ResNet18 {
    /// Creates a network with `width` channels in the first stage; 64 is ResNet-18 itself.
    pub fn new(scope: &Scope, width: usize) -> Result<Self> {
        Ok(Self {
            stem: Stem::new(&scope.at("conv1"), &scope.at("bn1"), width)?,
            stages: Stage::all_four(scope, width)?,
        })
    }

    /// Maps images (batch, 3, height, width) to features (batch, 8 width).
    pub fn forward(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        let mut x = self.stem.forward(images, mode)?;
        for stage in &self.stages {
            x = stage.forward(&x, mode)?;
        }
        Ok(ops::adaptive_avg_pool(&x, 1)?.flatten_from(1)?)
    }
}
