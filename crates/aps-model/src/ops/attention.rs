//! Operations of a transformer besides linear maps: attention by head, layer normalisation by row.

use candle_core::{Result, Tensor};

use super::cpu::{apply, are_fast};
use super::portable::{self, LAYER_EPSILON};
use crate::kernels::attention::{Heads, attend, attend_gradient};
use crate::kernels::layer_norm as norm;
use crate::recording::{Graph, Value, float, int, ints, recorded};

/// [`portable::layer_norm`].
pub(crate) fn layer_norm(x: &Tensor, weight: &Tensor, bias: &Tensor) -> Result<Tensor> {
    let inputs = [x, weight, bias];
    let epsilon = float("epsilon", LAYER_EPSILON);
    let nodes = |g: &mut Graph, v: &[Value]| g.node("LayerNormalization", v, [epsilon]);
    recorded(&inputs, nodes, || {
        let features = x.dims().last().copied().unwrap_or(0);
        let fits = [weight, bias].iter().all(|t| t.dims() == [features]);
        if !are_fast(&inputs) || x.elem_count() == 0 || !fits {
            return portable::layer_norm(x, weight, bias);
        }
        let forward = |[x, w, b]: [&[f32]; 3]| norm::layer_norm(x, w, b, LAYER_EPSILON);
        apply("layer_norm", inputs, x.dims(), forward, |b| {
            let [x, weight, _] = b.inputs;
            norm::layer_norm_gradients(x, weight, b.grad, LAYER_EPSILON).map(Some)
        })
    })
}

/// [`portable::self_attention`].
pub(crate) fn self_attention(all: &Tensor, heads: usize) -> Result<Tensor> {
    let (batch, tokens, all_width) = all.dims3()?;
    let width = all_width / 3;
    let nodes = |g: &mut Graph, v: &[Value]| {
        let depth = width / heads;
        let parts = g.reshape(v[0], &[tokens, 3, heads, depth]);
        let mut part = |n: usize, order: [i64; 4]| {
            let part = g.slice(parts, 2, [n, n + 1]);
            let part = g.reshape(part, &[tokens, heads, depth]);
            g.node("Transpose", &[part], [ints("perm", order)])
        };
        let (queries, keys) = (part(0, [0, 2, 1, 3]), part(1, [0, 2, 3, 1]));
        let values = part(2, [0, 2, 1, 3]);
        let factor = g.number(1.0 / (depth as f64).sqrt());
        let queries = g.node("Mul", &[queries, factor], []);
        let scores = g.node("MatMul", &[queries, keys], []);
        let shares = g.node("Softmax", &[scores], [int("axis", -1)]);
        let mixed = g.node("MatMul", &[shares, values], []);
        let mixed = g.node("Transpose", &[mixed], [ints("perm", [0, 2, 1, 3])]);
        g.reshape(mixed, &[tokens, width])
    };
    recorded(&[all], nodes, || {
        let is_empty = all.elem_count() * heads == 0;
        if !are_fast(&[all]) || is_empty || !all_width.is_multiple_of(3 * heads) {
            return portable::self_attention(all, heads);
        }
        let sizes = Heads {
            tokens,
            heads,
            depth: width / heads,
        };
        apply(
            "self_attention",
            [all],
            &[batch, tokens, width],
            move |[all]| attend(all, sizes),
            move |b| [Some(attend_gradient(b.inputs[0], b.grad, sizes))],
        )
    })
}
