//! Adv-MLP: MS-AReg with a single-scale encoder.

use candle_core::{Module, ModuleT, Result, Tensor};
use candle_nn::VarBuilder;

use super::noise::NoiseInput;
use super::{Model, Spec, check_images, decoder_sizes, width};
use crate::condition::InputKind;
use crate::layers::{Mlp, ResNet18};
use crate::loss::Loss;

pub(crate) const SPEC: Spec = Spec {
    name: "adv_mlp",
    title: "Adv-MLP",
    loss: Loss::Adversarial,
    input: InputKind::Images,
    build: |preset, _, vb| Ok(Box::new(AdvMlp::new(width(preset), vb)?)),
    settings: |usual| usual,
};

/// A [`ResNet18`] (`encoder`), zeros through `noise_proj`, and a perceptron (`decoder`). Trained against a
/// [`Regularizer`](super::Regularizer), which it does not need afterwards.
#[derive(Debug, Clone)]
pub(crate) struct AdvMlp {
    encoder: ResNet18,
    noise: NoiseInput,
    decoder: Mlp,
}

impl AdvMlp {
    /// Creates the model. The paper has `width` 64: 13,663,732 trainable parameters.
    pub fn new(width: usize, vb: VarBuilder<'_>) -> Result<Self> {
        Ok(Self {
            encoder: ResNet18::new(width, vb.pp("encoder"))?,
            noise: NoiseInput::new(width, &vb)?,
            decoder: Mlp::new(&decoder_sizes(12 * width, width), vb.pp("decoder"))?,
        })
    }
}

impl ModuleT for AdvMlp {
    fn forward_t(&self, images: &Tensor, train: bool) -> Result<Tensor> {
        check_images(images)?;
        let features = self.encoder.forward_t(images, train)?;
        self.decoder.forward(&self.noise.append(&features)?)
    }
}

impl Model for AdvMlp {}
