//! Dropout.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use candle_core::{ModuleT, Result, Tensor};
use rand_chacha::ChaCha8Rng;

use crate::random::{Purpose, generator, unit};

/// Dropout: in training each element is zeroed with a probability and the others are scaled by 1 / (1 - probability)
/// (Srivastava et al., JMLR 15, 2014); else the layer is the identity.
///
/// Masks are drawn on the host, so that they are the same on every device, from a generator of the layer's own: pass after
/// pass from one stream, or from the stream of a step that [`seed`](Self::seed) names. Clones share the generator.
#[derive(Debug, Clone)]
pub(crate) struct Dropout {
    probability: f64,
    generator: Arc<Mutex<ChaCha8Rng>>,
}

impl Dropout {
    /// Creates a layer that begins with the masks of step 0 of seed 0.
    pub fn new(probability: f64) -> Self {
        Self {
            probability,
            generator: Arc::new(Mutex::new(generator(0, Purpose::Dropout, 0))),
        }
    }

    /// Sets the masks of the next passes to those of a step.
    pub fn seed(&self, seed: u64, step: u64) {
        *self.lock() = generator(seed, Purpose::Dropout, step);
    }

    fn lock(&self) -> MutexGuard<'_, ChaCha8Rng> {
        let guard = self.generator.lock();
        guard.unwrap_or_else(PoisonError::into_inner)
    }
}

impl ModuleT for Dropout {
    fn forward_t(&self, x: &Tensor, train: bool) -> Result<Tensor> {
        if !train || self.probability <= 0.0 {
            return Ok(x.clone());
        }
        let scale = (1.0 / (1.0 - self.probability)) as f32;
        let mut generator = self.lock();
        let factor = |_| match unit(&mut generator) < self.probability {
            true => 0.0,
            false => scale,
        };
        let mask: Vec<f32> = (0..x.elem_count()).map(factor).collect();
        let mask = Tensor::from_vec(mask, x.dims(), x.device())?;
        x * mask.to_dtype(x.dtype())?
    }
}
