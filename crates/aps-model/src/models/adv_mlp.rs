//! Adv-MLP: MS-AReg with a single-scale encoder.

use candle_core::Tensor;

use super::noise::NoiseInput;
use super::{check_images, decoder_sizes};
use crate::layers::{Mlp, ResNet18};
use crate::{Mode, Model, Parameters, Result};

/// A [`ResNet18`] (`encoder`), zeros through `noise_proj`, and a perceptron (`decoder`). Trained against a
/// [`Regularizer`](super::Regularizer), which it does not need afterwards.
#[derive(Debug, Clone)]
pub struct AdvMlp {
    encoder: ResNet18,
    noise: NoiseInput,
    decoder: Mlp,
    parameters: Parameters,
}

impl AdvMlp {
    /// Creates the model's tensors in `parameters`. The paper has `width` 64: 13,663,732 trainable parameters.
    pub fn new(parameters: &Parameters, width: usize) -> Result<Self> {
        let root = parameters.root();
        Ok(Self {
            encoder: ResNet18::new(&root.at("encoder"), width)?,
            noise: NoiseInput::new(&root, width)?,
            decoder: Mlp::new(&root.at("decoder"), &decoder_sizes(12 * width, width))?,
            parameters: parameters.clone(),
        })
    }
}

impl Model for AdvMlp {
    fn forward(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        check_images(images)?;
        let features = self.encoder.forward(images, mode)?;
        self.decoder.forward(&self.noise.append(&features)?)
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }
}
