//! Errors of predictions and labels that are to be scored.

use std::path::PathBuf;

use aps_data::npy::shape_text;
use aps_metrics::Defect;

/// Fault of predictions or labels that are to be scored.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScoreError {
    /// A file with other axes.
    #[error("'{}' has shape {}, expected {expected}", path.display(), shape_text(found))]
    Shape {
        /// The file.
        path: PathBuf,
        /// Its axes.
        found: Vec<usize>,
        /// Description of the axes expected.
        expected: &'static str,
    },
    /// A number that is no id of a map.
    #[error("'{}' holds {value}, but a map id is an integer from 0 to {}", path.display(), u32::MAX)]
    MapId {
        /// The file.
        path: PathBuf,
        /// The number.
        value: f64,
    },
    /// A data set that has nothing to normalise labels by.
    #[error("the data set has no label in its training maps to normalise by")]
    NoTrainingLabel,
    /// A data set whose labels do not vary over the angle, as those of one element.
    #[error(
        "the labels of the training maps are all flat: there is nothing to normalise by; make them with more elements"
    )]
    FlatLabels,
    /// Truth without a spectrum.
    #[error("{0} holds no sample")]
    NoSample(String),
    /// A data set with another number of labels than its manifest says.
    #[error("'{folder}' has not the {samples} valid links of its manifest: it is damaged")]
    Damaged {
        /// The data set.
        folder: String,
        /// Valid links by the manifest.
        samples: usize,
    },
    /// A prediction for other links, by the file beside it that names them.
    #[error(
        "by '{}' the prediction is for other links, from row {row} on; predict those that are to be scored, or remove that file if it \
         is not of this prediction",
        path.display()
    )]
    OtherLinks {
        /// The file.
        path: PathBuf,
        /// The first row of another link.
        row: usize,
    },
    /// A prediction of other labels, by the file beside it that names them.
    #[error(
        "by '{}' the prediction is of labels of the {what} {found}, those to be scored are of {expected}: the same spectrum means something else \
         there; predict those that are to be scored, or remove that file if it is not of this prediction",
        path.display()
    )]
    OtherLabels {
        /// The file.
        path: PathBuf,
        /// `protocol` or `array`.
        what: &'static str,
        /// Protocol or array of the prediction.
        found: String,
        /// Protocol or array of the labels.
        expected: String,
    },
    /// No sample without NaN and infinities.
    #[error(
        "none of {samples} samples can be scored: each holds NaN or an infinity; the first: {first}"
    )]
    NoneScored {
        /// Number of samples.
        samples: usize,
        /// Defect of the first.
        first: Defect,
    },
}
