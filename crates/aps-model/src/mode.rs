//! Mode of a forward pass: training or evaluation.

use std::sync::{Mutex, MutexGuard, PoisonError};

use rand_chacha::ChaCha8Rng;

/// Mode of a forward pass, on which batch normalisation and dropout depend.
#[derive(Debug, Clone, Copy)]
pub enum Mode<'a> {
    /// Running statistics, no dropout: the same input gives the same output.
    Eval,
    /// Batch statistics, which also move the running ones; dropout drawn from the generator.
    Train(&'a Mutex<ChaCha8Rng>),
}

impl<'a> Mode<'a> {
    /// Returns true when this is [`Mode::Train`].
    pub fn is_training(self) -> bool {
        matches!(self, Self::Train(_))
    }

    /// Returns the generator of a training pass, locked; `None` in [`Mode::Eval`].
    pub fn generator(self) -> Option<MutexGuard<'a, ChaCha8Rng>> {
        match self {
            Self::Eval => None,
            // A generator has no state that a panic elsewhere could leave half changed.
            Self::Train(generator) => {
                Some(generator.lock().unwrap_or_else(PoisonError::into_inner))
            }
        }
    }
}
