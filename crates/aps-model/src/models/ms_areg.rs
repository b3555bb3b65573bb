//! MS-AReg, the paper's reference model, and its ablations: MS-MLP, without adversarial training, and Adv-MLP, with an encoder
//! of a single scale.

use candle_core::{Module, ModuleT, Result, Tensor};
use candle_nn::VarBuilder;

use super::check::check_images;
use super::{Model, Spec, width};
use crate::condition::InputKind;
use crate::layers::{Linear, Mlp, MultiScaleEncoder, ResNet18};
use crate::loss::Loss;
use crate::{ANGLE_BINS, ops};

pub(crate) const MS_AREG: Spec = Spec {
    name: "ms_areg",
    title: "MS-AReg",
    loss: Loss::Adversarial,
    input: InputKind::Images,
    build: |preset, _, vb| Ok(Box::new(MsAreg::new(width(preset), vb)?)),
    settings: |usual| usual,
};

pub(crate) const MS_MLP: Spec = Spec {
    name: "ms_mlp",
    title: "MS-MLP",
    loss: Loss::Squared,
    build: |preset, _, vb| Ok(Box::new(MsAreg::ms_mlp(width(preset), vb)?)),
    ..MS_AREG
};

pub(crate) const ADV_MLP: Spec = Spec {
    name: "adv_mlp",
    title: "Adv-MLP",
    build: |preset, _, vb| Ok(Box::new(MsAreg::adv_mlp(width(preset), vb)?)),
    ..MS_AREG
};

/// An encoder (`encoder`), zeros through `noise_proj`, and a perceptron (`decoder`).
///
/// The zeros are a noise that the adversarially trained predictors keep from their generative origin: only the bias of the
/// projection has an effect, and only it is trained. These are trained against a [`Regularizer`](super::Regularizer), which
/// they do not need afterwards.
#[derive(Debug, Clone)]
pub(crate) struct MsAreg {
    encoder: Encoder,
    noise: Option<Linear>,
    decoder: Mlp,
    width: usize,
}

#[derive(Debug, Clone)]
enum Encoder {
    Scales(MultiScaleEncoder),
    Single(ResNet18),
}

impl MsAreg {
    /// Creates MS-AReg. The paper has `width` 64: 15,042,036 trainable parameters.
    pub fn new(width: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let encoder = MultiScaleEncoder::new(width, vb.pp("encoder"))?;
        Self::behind(Encoder::Scales(encoder), true, width, vb)
    }

    /// Creates MS-MLP. The paper has `width` 64: 14,746,868 trainable parameters.
    pub fn ms_mlp(width: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let encoder = MultiScaleEncoder::new(width, vb.pp("encoder"))?;
        Self::behind(Encoder::Scales(encoder), false, width, vb)
    }

    /// Creates Adv-MLP. The paper has `width` 64: 13,663,732 trainable parameters.
    pub fn adv_mlp(width: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let encoder = ResNet18::new(width, vb.pp("encoder"))?;
        Self::behind(Encoder::Single(encoder), true, width, vb)
    }

    fn behind(encoder: Encoder, has_noise: bool, width: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let inputs = if has_noise { 12 * width } else { 8 * width };
        let project = || Linear::new(2 * width, 4 * width, vb.pp("noise_proj"));
        let sizes = [inputs, 16 * width, 16 * width, 8 * width, ANGLE_BINS];
        Ok(Self {
            encoder,
            noise: has_noise.then(project).transpose()?,
            decoder: Mlp::new(&sizes, vb.pp("decoder"))?,
            width,
        })
    }
}

impl ModuleT for MsAreg {
    fn forward_t(&self, images: &Tensor, train: bool) -> Result<Tensor> {
        check_images(images)?;
        let mut features = match &self.encoder {
            Encoder::Scales(encoder) => encoder.forward_t(images, train)?.global,
            Encoder::Single(encoder) => encoder.forward_t(images, train)?,
        };
        if let Some(projection) = &self.noise {
            let zeros = ops::zeros(2 * self.width, &features)?;
            features = ops::cat(&[&features, &projection.forward(&zeros)?], 1)?;
        }
        self.decoder.forward(&features)
    }
}

impl Model for MsAreg {}
