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
    /// A tensor given to a layer or a model does not have the shape it needs.
    #[error("{what} must have the shape {expected}, not {found:?}")]
    Shape {
        /// Which tensor.
        what: &'static str,
        /// The shape it needs.
        expected: String,
        /// The shape it has.
        found: Vec<usize>,
    },
    /// Batch normalisation has only one value a channel to learn from, whose variance says nothing.
    #[error(
        "batch normalisation needs more than one value a channel in training, found shape {found:?}; use a batch of two or more \
         samples, or larger images"
    )]
    OneValueAChannel {
        /// Shape of its input.
        found: Vec<usize>,
    },
    /// Two layers of a model ask for the same tensor.
    #[error("the model already has a tensor {name}")]
    DuplicateTensor {
        /// Its full name.
        name: String,
    },
    /// A word that names no model or no preset.
    #[error("unknown {what} \"{found}\"; known are {known}")]
    UnknownName {
        /// What it should have named.
        what: &'static str,
        /// The word.
        found: String,
        /// All names, with commas.
        known: String,
    },
    /// Sizes of a model that fit no layer.
    #[error("{what}")]
    Config {
        /// What is wrong, with the values.
        what: String,
    },
}

/// Checks that `tensor` has the dimensions of `expected`, where 0 stands for any size.
pub(crate) fn check_shape(
    what: &'static str,
    tensor: &candle_core::Tensor,
    expected: &[usize],
) -> Result<()> {
    let found = tensor.dims();
    let fits = found.len() == expected.len()
        && found
            .iter()
            .zip(expected)
            .all(|(&f, &e)| if e == 0 { f > 0 } else { f == e });
    if fits {
        return Ok(());
    }
    let sizes: Vec<_> = expected
        .iter()
        .map(|&e| {
            if e == 0 {
                "any".to_owned()
            } else {
                e.to_string()
            }
        })
        .collect();
    Err(Error::Shape {
        what,
        expected: format!("[{}]", sizes.join(", ")),
        found: found.to_vec(),
    })
}
