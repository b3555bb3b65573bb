//! The multi-scale encoder of MS-AReg.

use candle_core::{Module, ModuleT, Result, Tensor};
use candle_nn::VarBuilder;

use super::Linear;
use super::resnet::{Stage, Stem};
use crate::ops;

/// Side of the grid to which the features of each stage are averaged.
const GRIDS: [usize; 4] = [4, 2, 1, 1];

/// Features of an image at four scales and all together.
#[derive(Debug, Clone)]
pub(crate) struct MultiScale {
    /// Features of each stage, fine to coarse: (batch, 4 width).
    pub scales: Vec<Tensor>,
    /// Fused features of all stages: (batch, 8 width).
    pub global: Tensor,
}

/// ResNet-18's stages (`stem.0`, `stem.1`, `layer1` to `layer4`), each averaged over a grid and projected (`proj1` to
/// `proj4`), then fused (`global_proj.0`, ReLU, `global_proj.2`).
#[derive(Debug, Clone)]
pub(crate) struct MultiScaleEncoder {
    stem: Stem,
    stages: Vec<Stage>,
    projections: Vec<Linear>,
    fuse: [Linear; 2],
}

impl MultiScaleEncoder {
    /// Creates an encoder with `width` channels in the first stage: 64 in the paper.
    pub fn new(width: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let scale = 4 * width;
        let project = |(n, grid): (usize, usize)| {
            let vb = vb.pp(format!("proj{}", n + 1));
            Linear::new((width << n) * grid * grid, scale, vb)
        };
        let projections = GRIDS.into_iter().enumerate().map(project);
        let (stem, fuse) = (vb.pp("stem"), vb.pp("global_proj"));
        Ok(Self {
            stem: Stem::new(width, stem.pp(0), stem.pp(1))?,
            stages: Stage::all_four(width, &vb)?,
            projections: projections.collect::<Result<_>>()?,
            fuse: [
                Linear::new(4 * scale, 2 * scale, fuse.pp(0))?,
                Linear::new(2 * scale, 2 * scale, fuse.pp(2))?,
            ],
        })
    }

    /// Computes the features of images (batch, 3, height, width).
    pub fn forward_t(&self, images: &Tensor, train: bool) -> Result<MultiScale> {
        let mut x = self.stem.forward_t(images, train)?;
        let mut scales = Vec::with_capacity(GRIDS.len());
        for ((stage, projection), grid) in self.stages.iter().zip(&self.projections).zip(GRIDS) {
            x = stage.forward_t(&x, train)?;
            let pooled = ops::flatten_from(&ops::adaptive_avg_pool(&x, grid)?, 1)?;
            scales.push(projection.forward(&pooled)?);
        }
        let all = ops::cat(&scales.iter().collect::<Vec<_>>(), 1)?;
        let hidden = ops::relu(&self.fuse[0].forward(&all)?)?;
        let global = self.fuse[1].forward(&hidden)?;
        Ok(MultiScale { scales, global })
    }
}
