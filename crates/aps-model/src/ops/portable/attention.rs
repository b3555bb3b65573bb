//! Self-attention.

use candle_core::{Result, Tensor};

use super::activation::softmax_last;

/// Scaled dot-product attention of a sequence with itself (Vaswani et al., NeurIPS 2017), from queries, keys and values side
/// by side, each head after head: (batch, tokens, 3 width) to (batch, tokens, width).
///
/// # Errors
/// candle's, where the last dimension is not a multiple of `3 * heads`.
pub(crate) fn self_attention(all: &Tensor, heads: usize) -> Result<Tensor> {
    let (batch, tokens, all_width) = all.dims3()?;
    let width = all_width / 3;
    let depth = width / heads.max(1);
    // (3, batch, heads, tokens, depth)
    let all = all
        .reshape((batch, tokens, 3, heads, depth))?
        .permute((2, 0, 3, 1, 4))?;
    let part = |n| all.get(n)?.contiguous();
    let queries = (part(0)? * (1.0 / (depth as f64).sqrt()))?;
    let scores = queries.matmul(&part(1)?.t()?)?;
    let mixed = softmax_last(&scores)?.matmul(&part(2)?)?;
    mixed.transpose(1, 2)?.reshape((batch, tokens, width))
}
