//! Operations of the layers: each defined once, with its gradient, for every device and type, and with its nodes of ONNX.
//!
//! Every layer of this crate calls these functions and no others, in evaluation also for sums, slices and the like: what
//! [`crate::onnx`] does not see it cannot export. With f32 on the CPU the heavy ones take the loops of
//! [`crate::kernels`]; [`portable`] computes everything else, on every GPU as well.

mod activation;
mod attention;
mod conv2d;
mod cpu;
mod elementwise;
mod linear;
mod norm;
mod normed_conv;
mod pool;
pub(crate) mod portable;
mod resize;
mod shape;
mod ways;

pub(crate) use self::activation::{add_relu, gelu, leaky_relu, max_last, relu, softmax};
pub(crate) use self::attention::{layer_norm, self_attention};
pub(crate) use self::conv2d::{conv_transpose2x2, conv1d, conv2d};
#[cfg(test)]
pub(crate) use self::cpu::as_on_a_device;
pub(crate) use self::cpu::with_slices;
pub(crate) use self::elementwise::{
    add, at_most, div, exp, log, mean_last, mul, scale, shift, sqrt, square, sub,
};
pub(crate) use self::linear::{linear, project};
pub(crate) use self::norm::batch_norm;
pub(crate) use self::normed_conv::{Activation, ConvTensors, normed_conv2d};
pub(crate) use self::pool::{adaptive_avg_pool, max_pool_2x2, max_pool_3x3_s2_p1};
pub(crate) use self::portable::{BatchNormTensors, add_to_columns, at_least_f32};
pub(crate) use self::resize::{resize_bilinear, upsample_nearest_2x};
pub(crate) use self::shape::{
    cat, fixed, flatten_from, narrow, repeat, reshape, squeeze, transpose, unsqueeze, zeros,
};
pub(crate) use self::ways::{WaysShape, sums_of_ways};
