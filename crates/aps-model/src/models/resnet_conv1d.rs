//! ResNet-Conv1D: the multi-scale encoder with a convolutional decoder along the angle.

use candle_core::Tensor;

use super::check_images;
use crate::layers::{BatchNorm, Conv1d, Film, LEAKY_SLOPE, Linear, MultiScaleEncoder};
use crate::{ANGLE_BINS, Mode, Model, Parameters, Result, Scope, ops};

/// A [`MultiScaleEncoder`] (`encoder`); `init_proj` makes a line of 45 elements of it, which two blocks double to 180
/// (`up1_...`, `up2_...`) and a third refines (`ref_...`), each modulated by the features of a finer stage. The names are
/// flat, those of the released code.
#[derive(Debug, Clone)]
pub struct ResnetConv1d {
    encoder: MultiScaleEncoder,
    init_proj: Linear,
    up1: Upsampling,
    up2: Upsampling,
    refine: Refinement,
    parameters: Parameters,
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
        root: &Scope,
        block: &str,
        inputs: usize,
        outputs: usize,
        condition: usize,
    ) -> Result<Self> {
        let at = |layer| root.at(format_args!("{block}_{layer}"));
        Ok(Self {
            conv1: Conv1d::same(&at("conv1"), inputs, outputs, 5)?,
            bn1: BatchNorm::new(&at("bn1"), outputs)?,
            film: Film::new(&at("film"), condition, outputs)?,
            conv2: Conv1d::same(&at("conv2"), outputs, outputs, 3)?,
            bn2: BatchNorm::new(&at("bn2"), outputs)?,
        })
    }

    fn forward(&self, x: &Tensor, condition: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        let x = self.conv1.forward(&ops::upsample_nearest_2x(x)?)?;
        let x = ops::leaky_relu(&self.bn1.forward(&x, mode)?, LEAKY_SLOPE)?;
        let x = self.conv2.forward(&self.film.forward(&x, condition)?)?;
        ops::leaky_relu(&self.bn2.forward(&x, mode)?, LEAKY_SLOPE)
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
    fn new(root: &Scope, inputs: usize, hidden: usize, condition: usize) -> Result<Self> {
        Ok(Self {
            conv1: Conv1d::same(&root.at("ref_conv1"), inputs, hidden, 3)?,
            bn1: BatchNorm::new(&root.at("ref_bn"), hidden)?,
            film: Film::new(&root.at("ref_film"), condition, hidden)?,
            conv2: Conv1d::same(&root.at("ref_conv2"), hidden, 1, 1)?,
        })
    }

    fn forward(&self, x: &Tensor, condition: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        let x = self.bn1.forward(&self.conv1.forward(x)?, mode)?;
        let x = ops::leaky_relu(&x, LEAKY_SLOPE)?;
        Ok(self
            .conv2
            .forward(&self.film.forward(&x, condition)?)?
            .squeeze(1)?)
    }
}

impl ResnetConv1d {
    /// Creates the model's tensors in `parameters`. The paper has `width` 64: 18,853,377 trainable parameters.
    pub fn new(parameters: &Parameters, width: usize) -> Result<Self> {
        let root = parameters.root();
        let scale = 4 * width;
        Ok(Self {
            encoder: MultiScaleEncoder::new(&root.at("encoder"), width)?,
            init_proj: Linear::new(&root.at("init_proj"), 2 * scale, scale * START)?,
            up1: Upsampling::new(&root, "up1", scale, 2 * width, scale)?,
            up2: Upsampling::new(&root, "up2", 2 * width, width, scale)?,
            refine: Refinement::new(&root, width, width / 2, scale)?,
            parameters: parameters.clone(),
        })
    }
}

impl Model for ResnetConv1d {
    fn forward(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        check_images(images)?;
        let features = self.encoder.forward(images, mode)?;
        let [s1, s2, s3, _] = &features.scales;
        let line = self.init_proj.forward(&features.global)?;
        let line = line.reshape((images.dim(0)?, (), START))?;
        let line = self.up1.forward(&line, s3, mode)?;
        let line = self.up2.forward(&line, s2, mode)?;
        self.refine.forward(&line, s1, mode)
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }
}
