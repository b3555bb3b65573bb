//! Loops over plain slices in f32, by which [`crate::ops`] computes on a CPU.
//!
//! Nothing here knows candle. Work is cut by the shape of the problem alone, never by the number of threads, and every
//! output value is summed by one thread in one order, so results have the same bits on any number of threads.

pub(crate) mod attention;
pub(crate) mod batch_norm;
mod buffer;
pub(crate) mod convolution;
mod each;
pub(crate) mod epilogue;
mod exponential;
pub(crate) mod gelu;
mod input_gradient;
pub(crate) mod layer_norm;
pub(crate) mod linear;
mod matmul;
pub(crate) mod max_pool;
pub(crate) mod rectifier;
mod regroup;
mod rows;
mod shape;
mod softmax;
mod sums;
mod unfold;
pub(crate) mod ways;
mod weight_gradient;
mod winograd;

pub(crate) use input_gradient::input_gradient;
pub(crate) use shape::ConvShape;
pub(crate) use weight_gradient::weight_gradient;
pub(crate) use winograd::KernelCache;
