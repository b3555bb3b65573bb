//! Operations of the layers: each defined once, with its gradient, for every device and type.
//!
//! Every layer of this crate calls these functions and no others. With f32 on the CPU the heavy ones take the loops of
//! [`crate::kernels`]; [`portable`] computes everything else, on every GPU as well.

mod activation;
mod attention;
mod conv2d;
mod cpu;
mod depthwise;
mod gated;
mod linear;
mod norm;
mod normed_conv;
mod pool;
pub(crate) mod portable;

pub(crate) use self::activation::{add_relu, gelu, leaky_relu};
pub(crate) use self::attention::{layer_norm, self_attention};
pub(crate) use self::conv2d::{conv_transpose2x2, conv2d};
pub(crate) use self::depthwise::depthwise;
pub(crate) use self::gated::{add_gated, mean_last};
pub(crate) use self::linear::linear;
pub(crate) use self::norm::{batch_norm, batch_norm_relu};
pub(crate) use self::normed_conv::{After, ConvTensors, normed_conv2d};
pub(crate) use self::pool::{max_pool_2x2, max_pool_3x3_s2_p1};
pub(crate) use self::portable::{
    BatchNormTensors, adaptive_avg_pool, at_least_f32, max_last, relu, resize_bilinear, sigmoid,
    softmax_last as softmax, upsample_nearest_2x,
};
