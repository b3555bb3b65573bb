//! Perceptrons with leaky ReLU.

use candle_core::Tensor;

use super::Linear;
use crate::{Result, Scope, ops};

/// Slope of every leaky ReLU in the models, for negative inputs.
pub const LEAKY_SLOPE: f64 = 0.2;

/// Linear layers with a leaky ReLU ([`LEAKY_SLOPE`]) after each but, where it is an output, the last.
///
/// Named as in a PyTorch `Sequential` that counts activations: 0, 2, 4, ...
#[derive(Debug, Clone)]
pub struct Mlp {
    layers: Vec<Linear>,
    activate_last: bool,
}

impl Mlp {
    /// Creates a perceptron that ends with a linear layer. `sizes`: inputs, hidden ones, outputs.
    pub fn new(scope: &Scope, sizes: &[usize]) -> Result<Self> {
        Self::make(scope, sizes, false)
    }

    /// Creates a perceptron that ends with an activation. `sizes`: inputs, hidden ones, outputs.
    pub fn activated(scope: &Scope, sizes: &[usize]) -> Result<Self> {
        Self::make(scope, sizes, true)
    }

    fn make(scope: &Scope, sizes: &[usize], activate_last: bool) -> Result<Self> {
        let layers = sizes
            .windows(2)
            .enumerate()
            .map(|(i, pair)| Linear::new(&scope.at(2 * i), pair[0], pair[1]))
            .collect::<Result<_>>()?;
        Ok(Self {
            layers,
            activate_last,
        })
    }

    /// Maps `x` (..., inputs) to (..., outputs).
    pub fn forward(&self, x: &Tensor) -> Result<Tensor> {
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
