//! What layers compute with: each operation once, with its gradient, whatever computes it.
//!
//! Every layer of this crate calls these functions and no others. [`crate::portable`] answers on every device and for
//! every floating-point type.

pub use crate::portable::{
    BatchNormTensors, adaptive_avg_pool, batch_norm, batch_norm_relu, conv_transpose2x2, conv2d,
    dropout, gelu, layer_norm, leaky_relu, linear, max_pool_2x2, max_pool_3x3_s2_p1, relu,
    resize_bilinear, softmax_last, upsample_nearest_2x,
};
