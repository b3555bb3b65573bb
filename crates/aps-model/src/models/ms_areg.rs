//! MS-AReg: the paper's reference model.

use candle_core::{Module, ModuleT, Result, Tensor};
use candle_nn::VarBuilder;

use super::noise::NoiseInput;
use super::{Model, Spec, check_images, decoder_sizes, width};
use crate::condition::InputKind;
use crate::layers::{Mlp, MultiScaleEncoder};
use crate::loss::Loss;

pub(crate) const SPEC: Spec = Spec {
    name: "ms_areg",
    title: "MS-AReg",
    loss: Loss::Adversarial,
    input: InputKind::Images,
    build: |preset, _, vb| Ok(Box::new(MsAreg::new(width(preset), vb)?)),
    settings: |usual| usual,
};

/// A [`MultiScaleEncoder`] (`encoder`), zeros through `noise_proj`, and a perceptron (`decoder`). Trained against a
/// [`Regularizer`](super::Regularizer), which it does not need afterwards.
#[derive(Debug, Clone)]
pub(crate) struct MsAreg {
    encoder: MultiScaleEncoder,
    noise: NoiseInput,
    decoder: Mlp,
}

impl MsAreg {
    /// Creates the model. The paper has `width` 64: 15,042,036 trainable parameters.
    pub fn new(width: usize, vb: VarBuilder<'_>) -> Result<Self> {
        Ok(Self {
            encoder: MultiScaleEncoder::new(width, vb.pp("encoder"))?,
            noise: NoiseInput::new(width, &vb)?,
            decoder: Mlp::new(&decoder_sizes(12 * width, width), vb.pp("decoder"))?,
        })
    }
}

impl ModuleT for MsAreg {
    fn forward_t(&self, images: &Tensor, train: bool) -> Result<Tensor> {
        check_images(images)?;
        let features = self.encoder.forward_t(images, train)?.global;
        self.decoder.forward(&self.noise.append(&features)?)
    }
}

impl Model for MsAreg {}
