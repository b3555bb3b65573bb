//! Perceptrons with leaky ReLU.

use candle_core::{Module, Result, Tensor};
use candle_nn::VarBuilder;

use super::Linear;
use crate::ops;

/// Slope of every leaky ReLU in the models, for negative inputs.
pub(crate) const LEAKY_SLOPE: f64 = 0.2;

/// Linear layers with a leaky ReLU ([`LEAKY_SLOPE`]) after each but, unless `activate_last`, the last.
///
/// Named as in a PyTorch `Sequential` that counts activations: 0, 2, 4, ...
#[derive(Debug, Clone)]
pub(crate) struct Mlp {
    layers: Vec<Linear>,
    activate_last: bool,
}

impl Mlp {
    /// Creates a perceptron that ends with a linear layer. `sizes`: inputs, hidden ones, outputs.
    pub fn new(sizes: &[usize], vb: VarBuilder<'_>) -> Result<Self> {
        let pairs = sizes.windows(2).enumerate();
        let layers = pairs.map(|(i, pair)| Linear::new(pair[0], pair[1], vb.pp(2 * i)));
        Ok(Self {
            layers: layers.collect::<Result<_>>()?,
            activate_last: false,
        })
    }

    /// Creates a perceptron that ends with an activation. `sizes`: inputs, hidden ones, outputs.
    pub fn activated(sizes: &[usize], vb: VarBuilder<'_>) -> Result<Self> {
        Ok(Self {
            activate_last: true,
            ..Self::new(sizes, vb)?
        })
    }
}

impl Module for Mlp {
    fn forward(&self, x: &Tensor) -> Result<Tensor> {
        let mut x = x.clone();
        for (i, layer) in self.layers.iter().enumerate() {
            x = layer.forward(&x)?;
            if self.activate_last || i + 1 < self.layers.len() {
                x = ops::leaky_relu(&x, LEAKY_SLOPE)?;
            }
        }
        Ok(x)
    }
}
