//! The encoder block of a vision transformer (Dosovitskiy et al., ICLR 2021) as in torchvision.

use candle_core::{Module, Result, Tensor};
use candle_nn::{Init, VarBuilder};

use super::{LayerNorm, Linear};
use crate::ops;
use crate::parameters::{fan_in, normal, xavier};

/// PyTorch's `MultiheadAttention` of a sequence with itself: `in_proj_weight` (3 width, width) and `in_proj_bias` hold the
/// maps to queries, keys and values one under the other; `out_proj`.
#[derive(Debug, Clone)]
struct SelfAttention {
    in_weight: Tensor,
    in_bias: Tensor,
    out: Linear,
    heads: usize,
}

impl SelfAttention {
    /// Creates a layer; `heads` must divide `width`.
    fn new(width: usize, heads: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let zero = Init::Const(0.0);
        let init = xavier(width, 3 * width);
        Ok(Self {
            in_weight: vb.get_with_hints((3 * width, width), "in_proj_weight", init)?,
            in_bias: vb.get_with_hints(3 * width, "in_proj_bias", zero)?,
            out: Linear::with_init(width, width, [fan_in(width), zero], vb.pp("out_proj"))?,
            heads,
        })
    }
}

impl Module for SelfAttention {
    fn forward(&self, x: &Tensor) -> Result<Tensor> {
        let all = ops::linear(x, &self.in_weight, &self.in_bias)?;
        self.out.forward(&ops::self_attention(&all, self.heads)?)
    }
}

/// `ln_1`, `self_attention`, `ln_2`, `mlp.0`, GELU, `mlp.3`, each half with a shortcut around it. It keeps the shape (batch,
/// tokens, width).
#[derive(Debug, Clone)]
pub(crate) struct EncoderBlock {
    ln_1: LayerNorm,
    attention: SelfAttention,
    ln_2: LayerNorm,
    mlp: [Linear; 2],
}

impl EncoderBlock {
    /// Creates a block with a hidden layer of four times the width.
    pub fn new(width: usize, heads: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let hidden = 4 * width;
        let mlp = |n: usize, inputs, outputs| {
            let init = [xavier(inputs, outputs), normal(1e-6)];
            Linear::with_init(inputs, outputs, init, vb.pp("mlp").pp(n))
        };
        Ok(Self {
            ln_1: LayerNorm::new(width, vb.pp("ln_1"))?,
            attention: SelfAttention::new(width, heads, vb.pp("self_attention"))?,
            ln_2: LayerNorm::new(width, vb.pp("ln_2"))?,
            mlp: [mlp(0, width, hidden)?, mlp(3, hidden, width)?],
        })
    }
}

impl Module for EncoderBlock {
    fn forward(&self, x: &Tensor) -> Result<Tensor> {
        let x = ops::add(x, &self.attention.forward(&self.ln_1.forward(x)?)?)?;
        let hidden = ops::gelu(&self.mlp[0].forward(&self.ln_2.forward(&x)?)?)?;
        ops::add(&x, &self.mlp[1].forward(&hidden)?)
    }
}
