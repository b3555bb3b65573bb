//! ResNet-MLP: the simplest of the models.

use candle_core::Tensor;

use super::check_images;
use crate::layers::{Linear, ResNet18};
use crate::{ANGLE_BINS, Mode, Model, Parameters, Result, ops};

/// A [`ResNet18`] (`encoder`), then `head.0`, ReLU, dropout, `head.3`.
#[derive(Debug, Clone)]
pub struct ResnetMlp {
    encoder: ResNet18,
    head: [Linear; 2],
    dropout: f64,
    parameters: Parameters,
}

impl ResnetMlp {
    /// Creates the model's tensors in `parameters`. The paper has `width` 64, 11,531,508 trainable parameters, and drops
    /// hidden features with probability `dropout` 0.1.
    pub fn new(parameters: &Parameters, width: usize, dropout: f64) -> Result<Self> {
        let root = parameters.root();
        let head = root.at("head");
        let features = 8 * width;
        Ok(Self {
            encoder: ResNet18::new(&root.at("encoder"), width)?,
            head: [
                Linear::new(&head.at(0), features, features)?,
                Linear::new(&head.at(3), features, ANGLE_BINS)?,
            ],
            dropout,
            parameters: parameters.clone(),
        })
    }
}

impl Model for ResnetMlp {
    fn forward(&self, images: &Tensor, mode: Mode<'_>) -> Result<Tensor> {
        check_images(images)?;
        let features = self.encoder.forward(images, mode)?;
        let hidden = ops::relu(&self.head[0].forward(&features)?)?;
        self.head[1].forward(&ops::dropout(&hidden, self.dropout, mode)?)
    }

    fn parameters(&self) -> &Parameters {
        &self.parameters
    }
}
