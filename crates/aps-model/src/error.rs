//! What can go wrong.

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// What can go wrong, where, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A tensor operation failed: shapes, memory, device.
    #[error(transparent)]
    Candle(#[from] candle_core::Error),
    /// Condition images cannot be made of what was given.
    #[error("condition images: {0}")]
    Condition(String),
    /// Examples are not what a training can learn from.
    #[error("examples: {0}")]
    Samples(String),
}
