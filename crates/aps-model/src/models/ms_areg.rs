//! MS-AReg: the paper's reference model.

use candle_core::Tensor;

use super::noise::NoiseInput;
use super::{check_images, decoder_sizes};
use crate::layers::{Mlp, MultiScaleEncoder};
use crate::{Mode, Model, Parameters, Result};

/// A [`MultiScaleEncoder`] (`encoder`), zeros through `noise_proj`, and a perceptron (`decoder`). Trained against a
/// [`Regularizer`](super::Regularizer), which it does not need afterwards.
#[derive(Debug, Clone)]
pub struct MsAreg {
    encoder: MultiScaleEncoder,
    noise: NoiseInput,
    decoder: Mlp,
    parameters: Parameters,
}

impl MsAreg {
    /// Creates the model's tensors in `parameters`. The paper has `width` 64: 15,042,036 trainable parameters.
    pub fn new(parameters: &Parameters, width: usize) -> Result<Self> {
        let root = parameters.root();
        Ok(Self {
            encoder: MultiScaleEncoder::new(&root.at("encoder"), width)?,
            noise: NoiseInput::new(&root, width)?,
            decoder: Mlp::new(&root.at("decoder"), &decoder_sizes(12 * width, width))?,
            parameters: parameters.clone(),
        })
    }
}

impl Model for MsAreg {
    fn forward(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        check_images(images)?;
        let features = self.encoder.forward(images, mode)?.global;
        self.decoder.forward(&self.noise.append(&features)?)
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }
}
