//! The regularizer of MS-AReg and Adv-MLP: a critic that is needed in training only.

use candle_core::{Module, ModuleT, Result, Tensor, bail};
use candle_nn::VarBuilder;

use super::check::check_images;
use crate::ANGLE_BINS;
use crate::layers::{Mlp, ResNet18};

/// Scores how well a spectrum and a condition image fit: a ResNet-18 of the image (`cond_encoder`), a perceptron of the
/// spectrum (`aps_encoder`), and a perceptron of both (`head`). It has parameters and an optimizer of its own.
#[derive(Debug, Clone)]
pub struct Regularizer {
    condition: ResNet18,
    spectrum: Mlp,
    head: Mlp,
}

impl Regularizer {
    /// Creates the regularizer. The paper has `width` 64: 11,925,825 trainable parameters.
    pub(crate) fn new(width: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let (wide, narrow) = (8 * width, 4 * width);
        Ok(Self {
            condition: ResNet18::new(width, vb.pp("cond_encoder"))?,
            spectrum: Mlp::activated(&[ANGLE_BINS, wide, narrow], vb.pp("aps_encoder"))?,
            head: Mlp::new(&[wide + narrow, wide, narrow, 1], vb.pp("head"))?,
        })
    }

    /// Encodes condition images (batch, 3, height, width), most of the work, into features (batch, 8 `width`) to
    /// [`score`](Self::score) any spectra with. In training each call moves the running statistics.
    pub fn encode(&self, images: &Tensor, train: bool) -> Result<Tensor> {
        check_images(images)?;
        self.condition.forward_t(images, train)
    }

    /// Computes logits (batch, 1) that spectra (batch, [`ANGLE_BINS`]) are the true ones of [encoded](Self::encode) images.
    pub fn score(&self, encoded: &Tensor, spectra: &Tensor) -> Result<Tensor> {
        let (found, expected) = (spectra.dims(), [encoded.dim(0)?, ANGLE_BINS]);
        if found != expected {
            bail!("spectra must have the shape {expected:?}, not {found:?}");
        }
        let spectrum = self.spectrum.forward(spectra)?;
        self.head.forward(&Tensor::cat(&[encoded, &spectrum], 1)?)
    }
}
