//! Operations written with plain tensor operations, differentiable on any device and in any floating-point type.
//!
//! candle 0.11 lacks some of them (adaptive and strided pooling, bilinear resizing and their gradients) and differs from
//! PyTorch in others: its `max_pool2d` spreads a gradient over ties, its `relu` passes the gradient where the input is 0,
//! its `layer_norm` and `softmax_last_dim` have no gradient, its `gelu_erf` has one of six digits. These have PyTorch's
//! values and PyTorch's gradients. Convolutions are products of matrices here, for candle's own are slow to differentiate and
//! wrong for some sizes. They are the reference the fast ones in [`crate::ops`] are tested against.

mod activation;
mod attention;
mod computed;
mod constants;
mod conv;
mod correlation;
mod linear;
mod norm;
mod pool;
mod resize;
mod sums;
mod unfold;

pub(crate) use activation::{gelu, leaky_relu, max_last, relu, softmax_last};
pub(crate) use attention::self_attention;
pub(crate) use conv::{conv_transpose2x2, conv2d};
#[cfg(test)]
pub(crate) use correlation::correlate;
pub(crate) use linear::linear;
pub(crate) use norm::{
    BatchNormTensors, EPSILON, LAYER_EPSILON, MOMENTUM, at_least_f32, batch_norm, layer_norm,
    values_a_channel,
};
pub(crate) use pool::{adaptive_avg_pool, averages, max_pool_2x2, max_pool_3x3_s2_p1};
pub(crate) use resize::{interpolation, resize_bilinear, upsample_nearest_2x};
pub(crate) use sums::add_to_columns;
