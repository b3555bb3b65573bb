//! ResNet-MLP: the simplest of the models.

use candle_core::{Module, ModuleT, Result, Tensor};
use candle_nn::VarBuilder;

use super::check::check_images;
use super::{Model, Spec, width};
use crate::condition::InputKind;
use crate::layers::{Dropout, Linear, ResNet18};
use crate::loss::Loss;
use crate::{ANGLE_BINS, ops};

pub(crate) const SPEC: Spec = Spec {
    name: "resnet_mlp",
    title: "ResNet-MLP",
    loss: Loss::Squared,
    input: InputKind::Images,
    build: |preset, _, vb| Ok(Box::new(ResnetMlp::new(width(preset), 0.1, vb)?)),
    settings: |usual| usual,
};

/// A [`ResNet18`] (`encoder`), then `head.0`, ReLU, dropout, `head.3`.
#[derive(Debug, Clone)]
pub(crate) struct ResnetMlp {
    encoder: ResNet18,
    head: [Linear; 2],
    dropout: Dropout,
}

impl ResnetMlp {
    /// Creates the model. The paper has `width` 64, 11,531,508 trainable parameters, and drops hidden features with
    /// probability `dropout` 0.1.
    pub fn new(width: usize, dropout: f64, vb: VarBuilder<'_>) -> Result<Self> {
        let (features, head) = (8 * width, vb.pp("head"));
        Ok(Self {
            encoder: ResNet18::new(width, vb.pp("encoder"))?,
            head: [
                Linear::new(features, features, head.pp(0))?,
                Linear::new(features, ANGLE_BINS, head.pp(3))?,
            ],
            dropout: Dropout::new(dropout),
        })
    }
}

impl ModuleT for ResnetMlp {
    fn forward_t(&self, images: &Tensor, train: bool) -> Result<Tensor> {
        check_images(images)?;
        let features = self.encoder.forward_t(images, train)?;
        let hidden = ops::relu(&self.head[0].forward(&features)?)?;
        self.head[1].forward(&self.dropout.forward_t(&hidden, train)?)
    }
}

impl Model for ResnetMlp {
    fn seed_dropout(&self, seed: u64, step: u64) {
        self.dropout.seed(seed, step);
    }
}
