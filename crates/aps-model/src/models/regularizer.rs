//! The regularizer of MS-AReg and Adv-MLP: a critic that is needed in training only.

use candle_core::Tensor;

use super::check_images;
use crate::error::check_shape;
use crate::layers::{Mlp, ResNet18};
use crate::{ANGLE_BINS, Mode, Parameters, Result};

/// Scores how well a spectrum and a condition image fit: a [`ResNet18`] of the image (`cond_encoder`), a perceptron of the
/// spectrum (`aps_encoder`), and a perceptron of both (`head`). It has its own parameters and its own optimizer.
#[derive(Debug, Clone)]
pub struct Regularizer {
    condition: ResNet18,
    spectrum: Mlp,
    head: Mlp,
    parameters: Parameters,
}

impl Regularizer {
    /// Creates the regularizer's tensors in `parameters`. The paper has `width` 64: 11,925,825 trainable parameters.
    pub fn new(parameters: &Parameters, width: usize) -> Result<Self> {
        let root = parameters.root();
        let (wide, narrow) = (8 * width, 4 * width);
        Ok(Self {
            condition: ResNet18::new(&root.at("cond_encoder"), width)?,
            spectrum: Mlp::activated(&root.at("aps_encoder"), &[ANGLE_BINS, wide, narrow])?,
            head: Mlp::new(&root.at("head"), &[wide + narrow, wide, narrow, 1])?,
            parameters: parameters.clone(),
        })
    }

    /// Computes logits (batch, 1) that spectra (batch, [`ANGLE_BINS`]) are the true ones of condition images
    /// (batch, 3, height, width). In [`Mode::Train`] each call moves the running statistics.
    pub fn forward(&self, images: &Tensor, spectra: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        self.score(&self.encode(images, mode)?, spectra)
    }

    /// Encodes the images, most of the work, into features (batch, 8 `width`) to [`score`](Self::score) any spectra with.
    /// In [`Mode::Train`] each call moves the running statistics.
    pub fn encode(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        check_images(images)?;
        self.condition.forward(images, mode)
    }

    /// Computes the logits (batch, 1) of spectra (batch, [`ANGLE_BINS`]) under [encoded](Self::encode) images.
    pub fn score(&self, encoded: &Tensor, spectra: &Tensor) -> Result<Tensor> {
        check_shape("spectra", spectra, &[encoded.dim(0)?, ANGLE_BINS])?;
        let spectrum = self.spectrum.forward(spectra)?;
        self.head.forward(&Tensor::cat(&[encoded, &spectrum], 1)?)
    }

    /// Returns all tensors of the regularizer, by their PyTorch names.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }
}
