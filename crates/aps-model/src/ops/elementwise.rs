//! Sums, products and functions of elements. Shapes are brought to each other as NumPy does.

use candle_core::{D, Result, Tensor};

use crate::recording::{int, ints, recorded};

/// x + y.
pub(crate) fn add(x: &Tensor, y: &Tensor) -> Result<Tensor> {
    let sum = || x.broadcast_add(y);
    recorded(&[x, y], |g, v| g.node("Add", v, []), sum)
}

/// x - y.
pub(crate) fn sub(x: &Tensor, y: &Tensor) -> Result<Tensor> {
    let difference = || x.broadcast_sub(y);
    recorded(&[x, y], |g, v| g.node("Sub", v, []), difference)
}

/// x y.
pub(crate) fn mul(x: &Tensor, y: &Tensor) -> Result<Tensor> {
    let product = || x.broadcast_mul(y);
    recorded(&[x, y], |g, v| g.node("Mul", v, []), product)
}

/// x / y.
pub(crate) fn div(x: &Tensor, y: &Tensor) -> Result<Tensor> {
    let quotient = || x.broadcast_div(y);
    recorded(&[x, y], |g, v| g.node("Div", v, []), quotient)
}

/// x times a number.
pub(crate) fn scale(x: &Tensor, factor: f64) -> Result<Tensor> {
    with_number("Mul", x, factor, || x * factor)
}

/// x plus a number.
pub(crate) fn shift(x: &Tensor, summand: f64) -> Result<Tensor> {
    with_number("Add", x, summand, || x + summand)
}

/// The smaller of x and a number.
pub(crate) fn at_most(x: &Tensor, bound: f64) -> Result<Tensor> {
    with_number("Min", x, bound, || x.minimum(bound))
}

fn with_number(
    operation: &str,
    x: &Tensor,
    number: f64,
    compute: impl FnOnce() -> Result<Tensor>,
) -> Result<Tensor> {
    recorded(
        &[x],
        |g, v| {
            let number = g.number(number);
            g.node(operation, &[v[0], number], [])
        },
        compute,
    )
}

/// exp(x).
pub(crate) fn exp(x: &Tensor) -> Result<Tensor> {
    recorded(&[x], |g, v| g.node("Exp", v, []), || x.exp())
}

/// The natural logarithm of x.
pub(crate) fn log(x: &Tensor) -> Result<Tensor> {
    recorded(&[x], |g, v| g.node("Log", v, []), || x.log())
}

/// x squared.
pub(crate) fn square(x: &Tensor) -> Result<Tensor> {
    recorded(&[x], |g, v| g.node("Mul", &[v[0], v[0]], []), || x.sqr())
}

/// The square root of x.
pub(crate) fn sqrt(x: &Tensor) -> Result<Tensor> {
    recorded(&[x], |g, v| g.node("Sqrt", v, []), || x.sqrt())
}

/// The mean along the last dimension, which is kept with length 1.
pub(crate) fn mean_last(x: &Tensor) -> Result<Tensor> {
    recorded(
        &[x],
        |g, v| g.node("ReduceMean", v, [ints("axes", [-1]), int("keepdims", 1)]),
        || x.mean_keepdim(D::Minus1),
    )
}
