//! Operations that move values or choose among them.

use candle_core::{DType, Result, Tensor, bail};

use crate::recording::{Graph, Value, int, ints, recorded};

/// Puts tensors one behind the other along a dimension.
pub(crate) fn cat(parts: &[&Tensor], dim: usize) -> Result<Tensor> {
    recorded(
        parts,
        |g, v| g.node("Concat", v, [int("axis", dim as i64)]),
        || Tensor::cat(parts, dim),
    )
}

/// Takes `len` elements of a dimension from `start` on.
pub(crate) fn narrow(x: &Tensor, dim: usize, start: usize, len: usize) -> Result<Tensor> {
    recorded(
        &[x],
        |g, v| g.slice(v[0], dim, [start, start + len]),
        || x.narrow(dim, start, len),
    )
}

/// Gives a tensor other dimensions behind the first.
pub(crate) fn reshape(x: &Tensor, rest: &[usize]) -> Result<Tensor> {
    recorded(
        &[x],
        |g, v| g.reshape(v[0], rest),
        || x.reshape([&[x.dim(0)?], rest].concat()),
    )
}

/// Joins the dimensions from `dim` on, which is not the first.
pub(crate) fn flatten_from(x: &Tensor, dim: usize) -> Result<Tensor> {
    match x.dims() {
        [_, rest @ ..] if (1..=rest.len()).contains(&dim) => {
            let (kept, joined) = rest.split_at(dim - 1);
            reshape(x, &[kept, &[joined.iter().product()]].concat())
        }
        dims => bail!("{dims:?} has no dimension {dim} behind the first"),
    }
}

/// Exchanges the last two dimensions of (batch, a, b).
pub(crate) fn transpose(x: &Tensor) -> Result<Tensor> {
    recorded(
        &[x],
        |g, v| g.node("Transpose", v, [ints("perm", [0, 2, 1])]),
        || x.transpose(1, 2),
    )
}

/// Drops a dimension of length 1.
pub(crate) fn squeeze(x: &Tensor, dim: usize) -> Result<Tensor> {
    with_axis("Squeeze", x, dim, || x.squeeze(dim))
}

/// Adds a dimension of length 1.
pub(crate) fn unsqueeze(x: &Tensor, dim: usize) -> Result<Tensor> {
    with_axis("Unsqueeze", x, dim, || x.unsqueeze(dim))
}

fn with_axis(
    operation: &str,
    x: &Tensor,
    dim: usize,
    compute: impl FnOnce() -> Result<Tensor>,
) -> Result<Tensor> {
    let node = |g: &mut Graph, v: &[Value]| {
        let dim = g.whole(&[dim as i64]);
        g.node(operation, &[v[0], dim], [])
    };
    recorded(&[x], node, compute)
}

/// Repeats a tensor (1, ...) for each element of the first dimension of `like`.
pub(crate) fn repeat(x: &Tensor, like: &Tensor) -> Result<Tensor> {
    let rest = match x.dims() {
        [1, rest @ ..] => rest,
        dims => bail!("{dims:?} is to be repeated along its first dimension, which is not 1"),
    };
    recorded(
        &[x, like],
        |g, v| g.repeat(v[0], rest, v[1]),
        || x.broadcast_as([&[like.dim(0)?], rest].concat()),
    )
}

/// Takes a tensor of zeros (1, n) for each element of the first dimension of `like`, whose type it has.
pub(crate) fn zeros(n: usize, like: &Tensor) -> Result<Tensor> {
    let one = recorded(
        &[],
        |g, _| g.numbers(&[1, n], &vec![0.0; n]),
        || Tensor::zeros((1, n), like.dtype(), like.device()),
    )?;
    repeat(&one, like)
}

/// Takes the values of a parameter that no gradient is asked of, in a type.
pub(crate) fn fixed(parameter: &Tensor, dtype: DType) -> Result<Tensor> {
    recorded(
        &[parameter],
        |_, v| v[0],
        || parameter.detach().to_dtype(dtype),
    )
}
