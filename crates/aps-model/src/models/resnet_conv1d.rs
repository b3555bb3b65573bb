//! ResNet-Conv1D: the multi-scale encoder with a convolutional decoder along the angle.

use candle_core::{Module, ModuleT, Result, Tensor};
use candle_nn::VarBuilder;

use super::check::check_images;
use super::{Model, Spec, width};
use crate::condition::InputKind;
use crate::layers::{BatchNorm, Conv1d, Film, LEAKY_SLOPE, Linear, MultiScaleEncoder};
use crate::loss::Loss;
use crate::{ANGLE_BINS, ops};

pub(crate) const SPEC: Spec = Spec {
    name: "resnet_conv1d",
    title: "ResNet-Conv1D",
    loss: Loss::Squared,
    input: InputKind::Images,
    build: |preset, _, vb| Ok(Box::new(ResnetConv1d::new(width(preset), vb)?)),
    settings: |usual| usual,
};

/// A [`MultiScaleEncoder`] (`encoder`); `init_proj` makes a line of 45 elements of it, which two blocks double to 180
/// (`up1_...`, `up2_...`) and a third refines (`ref_...`), each modulated by the features of a finer stage. The names are
/// flat, those of the released code.
#[derive(Debug, Clone)]
pub(crate) struct ResnetConv1d {
    encoder: MultiScaleEncoder,
    init_proj: Linear,
    up1: Upsampling,
    up2: Upsampling,
    refine: Refinement,
}

/// Length of the line that the encoder's features become.
const START: usize = ANGLE_BINS / 4;

/// Doubles a line: nearest neighbours, `conv1` (5), `bn1`, leaky ReLU, `film`, `conv2` (3), `bn2`, leaky ReLU.
#[derive(Debug, Clone)]
struct Upsampling {
    conv1: Conv1d,
    bn1: BatchNorm,
    film: Film,
    conv2: Conv1d,
    bn2: BatchNorm,
}

impl Upsampling {
    fn new(
        block: &str,
        inputs: usize,
        outputs: usize,
        condition: usize,
        vb: &VarBuilder<'_>,
    ) -> Result<Self> {
        let at = |layer| vb.pp(format_args!("{block}_{layer}"));
        Ok(Self {
            conv1: Conv1d::same(inputs, outputs, 5, at("conv1"))?,
            bn1: BatchNorm::new(outputs, at("bn1"))?,
            film: Film::new(condition, outputs, at("film"))?,
            conv2: Conv1d::same(outputs, outputs, 3, at("conv2"))?,
            bn2: BatchNorm::new(outputs, at("bn2"))?,
        })
    }

    fn forward(&self, x: &Tensor, condition: &Tensor, train: bool) -> Result<Tensor> {
        let x = self.conv1.forward(&ops::upsample_nearest_2x(x)?)?;
        let x = ops::leaky_relu(&self.bn1.forward_t(&x, train)?, LEAKY_SLOPE)?;
        let x = self.conv2.forward(&self.film.forward(&x, condition)?)?;
        ops::leaky_relu(&self.bn2.forward_t(&x, train)?, LEAKY_SLOPE)
    }
}

/// Makes the spectrum: `conv1` (3), `bn`, leaky ReLU, `film`, `conv2` (1) to one channel.
#[derive(Debug, Clone)]
struct Refinement {
    conv1: Conv1d,
    bn1: BatchNorm,
    film: Film,
    conv2: Conv1d,
}

impl Refinement {
    fn new(inputs: usize, hidden: usize, condition: usize, vb: &VarBuilder<'_>) -> Result<Self> {
        Ok(Self {
            conv1: Conv1d::same(inputs, hidden, 3, vb.pp("ref_conv1"))?,
            bn1: BatchNorm::new(hidden, vb.pp("ref_bn"))?,
            film: Film::new(condition, hidden, vb.pp("ref_film"))?,
            conv2: Conv1d::same(hidden, 1, 1, vb.pp("ref_conv2"))?,
        })
    }

    fn forward(&self, x: &Tensor, condition: &Tensor, train: bool) -> Result<Tensor> {
        let x = self.bn1.forward_t(&self.conv1.forward(x)?, train)?;
        let x = ops::leaky_relu(&x, LEAKY_SLOPE)?;
        let x = self.conv2.forward(&self.film.forward(&x, condition)?)?;
        ops::squeeze(&x, 1)
    }
}

impl ResnetConv1d {
    /// Creates the model. The paper has `width` 64: 18,853,377 trainable parameters.
    pub fn new(width: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let scale = 4 * width;
        Ok(Self {
            encoder: MultiScaleEncoder::new(width, vb.pp("encoder"))?,
            init_proj: Linear::new(2 * scale, scale * START, vb.pp("init_proj"))?,
            up1: Upsampling::new("up1", scale, 2 * width, scale, &vb)?,
            up2: Upsampling::new("up2", 2 * width, width, scale, &vb)?,
            refine: Refinement::new(width, width / 2, scale, &vb)?,
        })
    }
}

impl ModuleT for ResnetConv1d {
    fn forward_t(&self, images: &Tensor, train: bool) -> Result<Tensor> {
        check_images(images)?;
        let features = self.encoder.forward_t(images, train)?;
        let line = self.init_proj.forward(&features.global)?;
        let line = ops::reshape(&line, &[line.dim(1)? / START, START])?;
        let line = self.up1.forward(&line, &features.scales[2], train)?;
        let line = self.up2.forward(&line, &features.scales[1], train)?;
        self.refine.forward(&line, &features.scales[0], train)
    }
}

impl Model for ResnetConv1d {}
