//! The strengths of ways, added by direction, as one operation.

use candle_core::{Result, Tensor};

use super::cpu::{apply, are_fast};
use crate::kernels::ways as kernel;
pub(crate) use crate::kernels::ways::WaysShape;
use crate::recording::is_recording;

/// Computes [`kernel::sums`] of ways (links, slots, features + 2), whose directions and kinds are below their numbers, and of weight and bias
/// of each layer in turn; where f32 on the CPU does not do it, and while a graph is recorded, `None`. No gradient is followed
/// through the ways.
pub(crate) fn sums_of_ways(
    ways: &Tensor,
    parameters: [&Tensor; 6],
    s: WaysShape,
) -> Result<Option<Tensor>> {
    if is_recording() || !are_fast(&[ways]) || !are_fast(&parameters) {
        return Ok(None);
    }
    let flat = parameters.map(Tensor::flatten_all);
    let flat = flat.into_iter().collect::<Result<Vec<_>>>()?;
    let dims = [ways.dim(0)?, s.directions];
    let sums = apply(
        "sums of ways",
        [&ways.detach(), &Tensor::cat(&flat, 0)?],
        &dims,
        move |[ways, parameters]| kernel::sums(ways, parameters, &s),
        move |b| {
            let [ways, parameters] = b.inputs;
            [None, Some(kernel::gradient(ways, parameters, b.grad, &s))]
        },
    );
    sums.map(Some)
}
