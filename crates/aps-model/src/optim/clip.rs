//! Clipping of gradients by the norm of all of them together.

use candle_core::backprop::GradStore;
use candle_core::{CpuStorage, DType, Storage, Tensor, Var};
use rayon::prelude::*;

use crate::Result;

/// Values summed at a time; fixed, so that the order of summation does not depend on the threads.
const BLOCK: usize = 1 << 14;

/// Added to the norm before dividing by it, as in PyTorch.
const EPSILON: f64 = 1e-6;

/// Euclidean norm of the gradients of `variables` taken as one vector; variables without one count as zero.
///
/// On a CPU squares are summed in f64. Not a number, or infinite, if a gradient is.
pub fn gradient_norm<'a>(
    gradients: &GradStore,
    variables: impl IntoIterator<Item = &'a Var>,
) -> Result<f64> {
    let mut squares = 0.0;
    for gradient in variables.into_iter().filter_map(|v| gradients.get(v)) {
        squares += sum_of_squares(gradient)?;
    }
    Ok(squares.sqrt())
}

/// Returns the factor that brings gradients of this norm to a norm of at most `max_norm`: 1 if it is.
pub fn clip_factor(norm: f64, max_norm: f64) -> f64 {
    (max_norm / (norm + EPSILON)).min(1.0)
}

fn sum_of_squares(gradient: &Tensor) -> Result<f64> {
    let gradient = gradient.contiguous()?;
    let (storage, layout) = gradient.storage_and_layout();
    if let (Storage::Cpu(CpuStorage::F32(values)), Some((start, end))) =
        (&*storage, layout.contiguous_offsets())
    {
        let square = |&x: &f32| f64::from(x) * f64::from(x);
        let blocks: Vec<f64> = values[start..end]
            .par_chunks(BLOCK)
            .map(|block| block.iter().map(square).sum())
            .collect();
        return Ok(blocks.iter().sum());
    }
    drop(storage);
    let sum = gradient.to_dtype(DType::F32)?.sqr()?.sum_all()?;
    Ok(f64::from(sum.to_scalar::<f32>()?))
}
