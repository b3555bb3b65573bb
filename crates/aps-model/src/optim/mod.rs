//! Optimization: [`Adam`], the [norm](gradient_norm) by which gradients are clipped, and the [`Schedule`] of the
//! learning rate.
//!
//! Numbers follow PyTorch's `torch.optim.AdamW`, `torch.nn.utils.clip_grad_norm_` operation by operation in f32, so that
//! trajectories agree to rounding. Results do not depend on the number of threads: elements are updated alone, and sums
//! run over blocks of fixed size in a fixed order.

mod adam;
mod clip;
mod fused;
mod schedule;

pub use adam::{Adam, AdamConfig};
pub use clip::{clip_factor, gradient_norm};
pub use schedule::Schedule;
