//! Adam's update in one pass over memory.

use std::sync::{Mutex, PoisonError};

use candle_core::{CpuStorage, InplaceOp2, Layout, Result, bail};
use rayon::prelude::*;

/// Values a thread updates at a time.
const BLOCK: usize = 1 << 14;

/// The numbers of one step, alike for all values.
#[derive(Debug, Clone, Copy)]
pub struct Coefficients {
    /// Gradients are multiplied by this first.
    pub gradient_scale: f64,
    /// Weights are multiplied by this: 1 - rate * decay.
    pub keep: f64,
    pub beta1: f64,
    pub beta2: f64,
    /// rate / (1 - beta1^t).
    pub step_size: f64,
    /// sqrt(1 - beta2^t).
    pub root_correction: f64,
    pub epsilon: f64,
}

/// Updates weights (the destination) and moments from a gradient (the source).
pub struct Fused<'a> {
    pub coefficients: Coefficients,
    /// First and second moments of the values; an operation is shared, hence the lock.
    pub moments: Mutex<(&'a mut [f32], &'a mut [f32])>,
}

impl InplaceOp2 for Fused<'_> {
    fn name(&self) -> &'static str {
        "adam"
    }

    fn cpu_fwd(
        &self,
        weights: &mut CpuStorage,
        weights_layout: &Layout,
        gradient: &CpuStorage,
        gradient_layout: &Layout,
    ) -> Result<()> {
        let ranges = (
            weights_layout.contiguous_offsets(),
            gradient_layout.contiguous_offsets(),
        );
        let (CpuStorage::F32(weights), CpuStorage::F32(gradient), (Some((w0, w1)), Some((g0, g1)))) =
            (weights, gradient, ranges)
        else {
            bail!("the fused update takes contiguous f32 tensors");
        };
        let mut moments = self.moments.lock().unwrap_or_else(PoisonError::into_inner);
        let (first, second) = &mut *moments;
        weights[w0..w1]
            .par_chunks_mut(BLOCK)
            .zip(gradient[g0..g1].par_chunks(BLOCK))
            .zip(first.par_chunks_mut(BLOCK))
            .zip(second.par_chunks_mut(BLOCK))
            .for_each(|(((w, g), m), v)| update(&self.coefficients, w, g, m, v));
        Ok(())
    }
}

/// The operations of `torch.optim.AdamW` on single tensors, in its order and precision.
fn update(c: &Coefficients, w: &mut [f32], g: &[f32], m: &mut [f32], v: &mut [f32]) {
    let (scale, keep) = (c.gradient_scale as f32, c.keep as f32);
    let (first_share, beta2, second_share) = (
        (1.0 - c.beta1) as f32,
        c.beta2 as f32,
        (1.0 - c.beta2) as f32,
    );
    let (step_size, root_correction, epsilon) = (
        c.step_size as f32,
        c.root_correction as f32,
        c.epsilon as f32,
    );
    for (((w, g), m), v) in w.iter_mut().zip(g).zip(m).zip(v) {
        let g = g * scale;
        *m += first_share * (g - *m);
        *v = *v * beta2 + second_share * (g * g);
        let denominator = v.sqrt() / root_correction + epsilon;
        *w = *w * keep - step_size * (*m / denominator);
    }
}
