//! The encoder block of a vision transformer (Dosovitskiy et al., ICLR 2021) as in torchvision.

use candle_core::Tensor;

use super::{LayerNorm, Linear};
use crate::{Init, Result, Scope, ops};

/// PyTorch's `MultiheadAttention` of a sequence with itself: `in_proj_weight` (3 width, width) and `in_proj_bias` hold the
/// maps to queries, keys and values one under the other; `out_proj`.
#[derive(Debug, Clone)]
pub struct SelfAttention {
    in_weight: Tensor,
    in_bias: Tensor,
    out: Linear,
    heads: usize,
}

impl SelfAttention {
    /// Creates a layer; `heads` must divide `width`.
    pub fn new(scope: &Scope, width: usize, heads: usize) -> Result<Self> {
        let init = Init::xavier(width, 3 * width);
        let out = Linear::with_init(
            &scope.at("out_proj"),
            width,
            width,
            Init::fan_in(width),
            Init::ZEROS,
        )?;
        Ok(Self {
            in_weight: scope.trainable("in_proj_weight", (3 * width, width), init)?,
            in_bias: scope.trainable("in_proj_bias", 3 * width, Init::ZEROS)?,
            out,
            heads,
        })
    }

    /// Maps `x` (batch, tokens, width) to the same shape.
    pub fn forward(&self, x: &Tensor) -> Result<Tensor> {
        let all = ops::linear(x, &self.in_weight, &self.in_bias)?;
        self.out.forward(&ops::self_attention(&all, self.heads)?)
    }
}

/// `ln_1`, `self_attention`, `ln_2`, `mlp.0`, GELU, `mlp.3`, each half with a shortcut around it.
#[derive(Debug, Clone)]
pub struct EncoderBlock {
    ln_1: LayerNorm,
    attention: SelfAttention,
    ln_2: LayerNorm,
    mlp: [Linear; 2],
}

impl EncoderBlock {
    /// Creates a block with a hidden layer of four times the width.
    pub fn new(scope: &Scope, width: usize, heads: usize) -> Result<Self> {
        let hidden = 4 * width;
        let mlp = |n: usize, inputs, outputs| {
            let scope = scope.at("mlp").at(n);
            Linear::with_init(
                &scope,
                inputs,
                outputs,
                Init::xavier(inputs, outputs),
                Init::Normal { std: 1e-6 },
            )
        };
        Ok(Self {
            ln_1: LayerNorm::new(&scope.at("ln_1"), width)?,
            attention: SelfAttention::new(&scope.at("self_attention"), width, heads)?,
            ln_2: LayerNorm::new(&scope.at("ln_2"), width)?,
            mlp: [mlp(0, width, hidden)?, mlp(3, hidden, width)?],
        })
    }

    /// Maps `x` (batch, tokens, width) to the same shape.
    pub fn forward(&self, x: &Tensor) -> Result<Tensor> {
        let x = (x + self.attention.forward(&self.ln_1.forward(x)?)?)?;
        let hidden = ops::gelu(&self.mlp[0].forward(&self.ln_2.forward(&x)?)?)?;
        Ok((&x + self.mlp[1].forward(&hidden)?)?)
    }
}
