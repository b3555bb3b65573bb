//! Operations of the layers: each defined once, with its gradient, for every device and type.
//!
//! Every layer of this crate calls these functions and no others. With f32 on the CPU the heavy ones take a fast path of
//! their own; [`crate::portable`] computes everything else, on every GPU as well.
//!
//! ```
//! use aps_model::candle_core::{DType, Device, Tensor, Var};
//! use aps_model::ops;
//!
//! let images = Tensor::ones((2, 3, 8, 8), DType::F32, &Device::Cpu)?;
//! let kernel = Var::ones((4, 3, 3, 3), DType::F32, &Device::Cpu)?;
//! let y = ops::leaky_relu(&ops::conv2d(&images, &kernel, None, 2, (1, 1))?, 0.2)?;
//! assert_eq!(y.dims(), [2, 4, 4, 4]);
//! let gradients = y.sum_all()?.backward()?;
//! assert_eq!(gradients.get(&kernel).unwrap().dims(), kernel.dims());
//! # Ok::<(), aps_model::Error>(())
//! ```

mod activation;
mod attention;
mod conv2d;
mod linear;
mod norm;
mod normed_conv;
mod pool;
mod storage;

pub use self::activation::{add_relu, gelu, leaky_relu};
pub use self::attention::{layer_norm, self_attention, softmax_last};
pub use self::conv2d::{conv_transpose2x2, conv2d};
pub use self::linear::linear;
pub use self::norm::{batch_norm, batch_norm_relu};
pub use self::normed_conv::{After, ConvTensors, Kept, normed_conv2d};
pub use self::pool::{max_pool_2x2, max_pool_3x3_s2_p1};
pub use crate::portable::{
    BatchNormTensors, adaptive_avg_pool, dropout, relu, resize_bilinear, upsample_nearest_2x,
};
