//! Errors that end a training.

use std::path::{Path, PathBuf};

use crate::condition::Link;

/// Errors that end a training; the message names the place and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrainError {
    /// The model or its input failed, or a file could not be read or written.
    #[error(transparent)]
    Model(#[from] crate::Error),
    /// A setting cannot be used.
    #[error("training settings: {0}")]
    Config(String),
    /// The loss or a gradient is not a number, or the loss is beyond any use. The weights are as they were before this
    /// step, but running statistics of the layers may not be.
    #[error(
        "step {step}: {quantity} is {value}; of the batch's {} links the worst are {}; {}; \
         look at their labels, lower the learning rate, or clip gradients harder",
        links.len(), worst(links), last_good(checkpoint.as_deref())
    )]
    Diverged {
        /// The step that was not made, counted from 0.
        step: u64,
        /// Quantity that is not sound: a loss, or the norm of gradients.
        quantity: &'static str,
        /// Value of the quantity.
        value: f64,
        /// Batch of the step: number and link of each example, the largest error first.
        links: Vec<(usize, Link)>,
        /// The checkpoint last written or read, if any.
        checkpoint: Option<PathBuf>,
    },
    /// A prediction is not finite.
    #[error(
        "the prediction of link {link} is not finite in bin {bin}: the weights are damaged, or belong elsewhere"
    )]
    Prediction {
        /// Number of the link.
        link: usize,
        /// First bin that is not finite.
        bin: usize,
    },
    /// A checkpoint cannot be used for this training.
    #[error("checkpoint '{path}': {problem}")]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// Description of the fault and its remedy.
        problem: String,
    },
    /// The training failed before. Only [`Trainer::resume`](super::Trainer::resume) goes on.
    #[error(
        "the training failed in an earlier step and cannot go on or be saved; continue from its last checkpoint"
    )]
    Failed,
}

impl From<candle_core::Error> for TrainError {
    fn from(error: candle_core::Error) -> Self {
        Self::Model(error.into())
    }
}

/// Names the first links of a list.
fn worst(links: &[(usize, Link)]) -> String {
    let named = links.iter().take(3).map(|(example, link)| {
        let Link { map, tx_m, rx_m } = link;
        format!("example {example} (map index {map}, Tx {tx_m:?} m, Rx {rx_m:?} m)")
    });
    named.collect::<Vec<_>>().join(", ")
}

fn last_good(checkpoint: Option<&Path>) -> String {
    match checkpoint {
        Some(path) => format!("the last good checkpoint is '{}'", path.display()),
        None => "no checkpoint has been written yet".into(),
    }
}
