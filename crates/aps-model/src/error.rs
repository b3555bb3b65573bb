//! Errors of models, weights and condition images.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Errors of this crate; the message names the place and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A tensor operation failed: shapes, names of tensors, memory, device.
    #[error(transparent)]
    Candle(#[from] candle_core::Error),
    /// Condition images cannot be made of the given maps, links or settings.
    #[error("condition images: {0}")]
    Condition(String),
    /// The input of a model, made outside of this crate, failed.
    #[error("the model's input cannot be made")]
    Input(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// Examples cannot be used for training.
    #[error("examples: {0}")]
    Samples(String),
    /// A word that names no model, preset, precision or frame.
    #[error("unknown {what} \"{found}\"; known are {known}")]
    UnknownName {
        /// Kind of thing that the word should name, as a model.
        what: &'static str,
        /// The word.
        found: String,
        /// Known names, with commas.
        known: String,
    },
    /// The operating system refused a file of weights.
    #[error("cannot {action} {}", path.display())]
    WeightsIo {
        /// Action that failed, as a verb.
        action: &'static str,
        /// File of the action.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A file holds no weights, or damaged ones.
    #[error("{} holds no weights that can be read: {problem}", path.display())]
    WeightsFormat {
        /// The file.
        path: PathBuf,
        /// Description of the fault.
        problem: String,
    },
    /// Weights do not fit the model.
    #[error("the weights in {} do not fit the model (is it another model, or another preset?):\n  {}", path.display(), problems.join("\n  "))]
    WeightsMismatch {
        /// The file.
        path: PathBuf,
        /// The tensors that are missing, unknown, misshapen or not finite, of many the first, and the file's other entries.
        problems: Vec<String>,
    },
    /// A file of weights says which model it is of, but not in this crate's words.
    #[error("the metadata of {} say under \"model\" that it is of \"{found}\", which is no model and preset of this version", path.display())]
    ForeignLabel {
        /// The file.
        path: PathBuf,
        /// Text of the label.
        found: String,
    },
    /// The model has no part that pretrained weights would fit.
    #[error(
        "the model has no ResNet-18 and no ViT-B/16 to fill with pretrained weights; train it from its initial values"
    )]
    NoBackbone,
}

impl Error {
    pub(crate) fn weights_io(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::WeightsIo {
            action,
            path: path.to_owned(),
            source,
        }
    }

    pub(crate) fn weights_format(path: &Path, problem: impl fmt::Display) -> Self {
        Self::WeightsFormat {
            path: path.to_owned(),
            problem: problem.to_string(),
        }
    }
}
