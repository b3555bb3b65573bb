//! The affine map.

use candle_core::{Result, Tensor};

use super::cpu::{apply, are_fast};
use super::portable;
use crate::kernels::linear as kernel;
use crate::recording::{Graph, Value, int, ints, recorded};

/// [`portable::linear`]: with f32 on the CPU the bias is there before the product is added to it, and gradients come in the
/// layout of their tensors instead of being turned afterwards.
pub(crate) fn linear(x: &Tensor, weight: &Tensor, bias: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| {
        if x.rank() == 2 {
            return g.node("Gemm", v, [int("transB", 1)]);
        }
        let turned = g.node("Transpose", &v[1..2], [ints("perm", [1, 0])]);
        let product = g.node("MatMul", &[v[0], turned], []);
        g.node("Add", &[product, v[2]], [])
    };
    recorded(&[x, weight, bias], nodes, || {
        let fits = match (x.dims(), weight.dims(), bias.dims()) {
            ([.., inputs], [outputs, columns], [biases]) => inputs == columns && outputs == biases,
            _ => false,
        };
        let is_empty = x.elem_count() == 0 || weight.elem_count() == 0;
        if !are_fast(&[x, weight, bias]) || !fits || is_empty {
            return portable::linear(x, weight, bias);
        }
        let (outputs, inputs) = weight.dims2()?;
        let dims = [&x.dims()[..x.rank() - 1], &[outputs]].concat();
        apply(
            "linear",
            [x, weight, bias],
            &dims,
            |[x, weight, bias]| kernel::linear(x, weight, bias),
            move |b| {
                let [x, weight, _] = b.inputs;
                let by_input = b.wanted[0].then(|| kernel::by_input(weight, b.grad, inputs));
                let (by_weight, by_bias) = kernel::by_weight_and_bias(x, b.grad, outputs);
                [by_input, Some(by_weight), Some(by_bias)]
            },
        )
    })
}

/// Computes x Wᵀ of (rows, in) and (out, in).
pub(crate) fn project(x: &Tensor, weight: &Tensor) -> Result<Tensor> {
    let nodes = |g: &mut Graph, v: &[Value]| g.node("Gemm", v, [int("transB", 1)]);
    recorded(&[x, weight], nodes, || x.matmul(&weight.t()?))
}
