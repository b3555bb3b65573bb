//! MS-MLP: MS-AReg without adversarial training.

use candle_core::Tensor;

use super::{check_images, decoder_sizes};
use crate::layers::{Mlp, MultiScaleEncoder};
use crate::{Mode, Model, Parameters, Result};

/// A [`MultiScaleEncoder`] (`encoder`) and a perceptron (`decoder`).
#[derive(Debug, Clone)]
pub struct MsMlp {
    encoder: MultiScaleEncoder,
    decoder: Mlp,
    parameters: Parameters,
}

impl MsMlp {
    /// Creates the model's tensors in `parameters`. The paper has `width` 64: 14,746,868 trainable parameters.
    pub fn new(parameters: &Parameters, width: usize) -> Result<Self> {
        let root = parameters.root();
        Ok(Self {
            encoder: MultiScaleEncoder::new(&root.at("encoder"), width)?,
            decoder: Mlp::new(&root.at("decoder"), &decoder_sizes(8 * width, width))?,
            parameters: parameters.clone(),
        })
    }
}

impl Model for MsMlp {
    fn forward(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        check_images(images)?;
        let features = self.encoder.forward(images, mode)?.global;
        self.decoder.forward(&features)
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }
}
