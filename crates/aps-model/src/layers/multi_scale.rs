//! The multi-scale encoder of MS-AReg.

use candle_core::Tensor;

use super::resnet::Stem;
use super::{Linear, Stage};
use crate::{Mode, Result, Scope, ops};

/// Side of the grid to which the features of each stage are averaged.
const GRIDS: [usize; 4] = [4, 2, 1, 1];

/// Features of an image at four scales and all together.
#[derive(Debug, Clone)]
pub struct MultiScale {
    /// Features of each stage, fine to coarse: (batch, 4 width).
    pub scales: [Tensor; 4],
    /// Fused features of all stages: (batch, 8 width).
    pub global: Tensor,
}

/// ResNet-18's stages (`stem.0`, `stem.1`, `layer1` to `layer4`), each averaged over a grid and projected (`proj1` to
/// `proj4`), then fused (`global_proj.0`, ReLU, `global_proj.2`).
#[derive(Debug, Clone)]
pub struct MultiScaleEncoder {
    stem: Stem,
    stages: [Stage; 4],
    projections: [Linear; 4],
    fuse: [Linear; 2],
}

impl MultiScaleEncoder {
    /// Creates an encoder with `width` channels in the first stage: 64 in the paper.
    pub fn new(scope: &Scope, width: usize) -> Result<Self> {
        let scale = 4 * width;
        let project = |n: usize| {
            let pooled = (width << n) * GRIDS[n] * GRIDS[n];
            Linear::new(&scope.at(format!("proj{}", n + 1)), pooled, scale)
        };
        let fuse = scope.at("global_proj");
        Ok(Self {
            stem: Stem::new(&scope.at("stem").at(0), &scope.at("stem").at(1), width)?,
            stages: Stage::all_four(scope, width)?,
            projections: [project(0)?, project(1)?, project(2)?, project(3)?],
            fuse: [
                Linear::new(&fuse.at(0), 4 * scale, 2 * scale)?,
                Linear::new(&fuse.at(2), 2 * scale, 2 * scale)?,
            ],
        })
    }

    /// Computes the features of images (batch, 3, height, width).
    pub fn forward(&self, images: &Tensor, mode: Mode<'_>) -> Result<MultiScale> {
        let mut x = self.stem.forward(images, mode)?;
        let mut scales = Vec::with_capacity(4);
        for ((stage, projection), grid) in self.stages.iter().zip(&self.projections).zip(GRIDS) {
            x = stage.forward(&x, mode)?;
            let pooled = ops::adaptive_avg_pool(&x, grid)?.flatten_from(1)?;
            scales.push(projection.forward(&pooled)?);
        }
        let hidden = ops::relu(&self.fuse[0].forward(&Tensor::cat(&scales, 1)?)?)?;
        let global = self.fuse[1].forward(&hidden)?;
        let [s1, s2, s3, s4] = &scales[..] else {
            unreachable!("four stages give four scales")
        };
        Ok(MultiScale {
            scales: [s1.clone(), s2.clone(), s3.clone(), s4.clone()],
            global,
        })
    }
}
