//! MS-MLP: MS-AReg without adversarial training.

use candle_core::{Module, ModuleT, Result, Tensor};
use candle_nn::VarBuilder;

use super::{Model, Spec, check_images, decoder_sizes, width};
use crate::condition::InputKind;
use crate::layers::{Mlp, MultiScaleEncoder};
use crate::loss::Loss;

pub(crate) const SPEC: Spec = Spec {
    name: "ms_mlp",
    title: "MS-MLP",
    loss: Loss::Squared,
    input: InputKind::Images,
    build: |preset, _, vb| Ok(Box::new(MsMlp::new(width(preset), vb)?)),
    settings: |usual| usual,
};

/// A [`MultiScaleEncoder`] (`encoder`) and a perceptron (`decoder`).
#[derive(Debug, Clone)]
pub(crate) struct MsMlp {
    encoder: MultiScaleEncoder,
    decoder: Mlp,
}

impl MsMlp {
    /// Creates the model. The paper has `width` 64: 14,746,868 trainable parameters.
    pub fn new(width: usize, vb: VarBuilder<'_>) -> Result<Self> {
        Ok(Self {
            encoder: MultiScaleEncoder::new(width, vb.pp("encoder"))?,
            decoder: Mlp::new(&decoder_sizes(8 * width, width), vb.pp("decoder"))?,
        })
    }
}

impl ModuleT for MsMlp {
    fn forward_t(&self, images: &Tensor, train: bool) -> Result<Tensor> {
        check_images(images)?;
        let features = self.encoder.forward_t(images, train)?.global;
        self.decoder.forward(&features)
    }
}

impl Model for MsMlp {}
