//! Whether a pass learns or only answers.

use std::sync::Mutex;

use rand_chacha::ChaCha8Rng;

/// How layers behave that differ between training and use: batch normalisation and dropout.
#[derive(Clone, Copy)]
pub enum Mode<'a> {
    /// Running statistics, no dropout: the same input gives the same output.
    Eval,
    /// Batch statistics, which also move the running ones; dropout drawn from the generator.
    Train(&'a Mutex<ChaCha8Rng>),
}

impl Mode<'_> {
    /// Whether this is [`Mode::Train`].
    pub fn is_training(self) -> bool {
        matches!(self, Self::Train(_))
    }
}
