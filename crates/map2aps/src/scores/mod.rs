//! Predictions of any model scored against labels.

mod array_file;
mod links;
mod truth;

use std::path::PathBuf;

use aps_data::npy::shape_text;
use aps_label::Protocol;
use aps_metrics::{DataRange, Defect, Error as MetricsError, Evaluation, Report, Shape, Spectra};

use crate::error::{At, Place, Result};

pub use array_file::ArrayFile;
pub use links::{LINK_COLUMNS, check_links, link_labels, link_line, links_file};
pub use truth::{Labels, Truth};

/// Values of spectra held at a time: 16 MB in f64, beside the scores of 120 bytes a sample.
const BLOCK_VALUES: usize = 1 << 21;

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
        /// That of the prediction.
        found: String,
        /// That of the labels.
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

/// Form that a data set's labels are turned into before a prediction is compared with them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Domain {
    /// The protocol's learning target, on which the benchmark's metrics are defined.
    #[default]
    Normalised,
    /// Linear power relative to the sample's maximum, in \[0, 1\].
    Linear,
}

impl Domain {
    /// Name of the form in reports.
    pub fn name(self) -> &'static str {
        match self {
            Domain::Normalised => "normalised",
            Domain::Linear => "linear",
        }
    }
}

/// Predicted spectra, one row a sample of the truth, in its order.
#[derive(Debug)]
#[non_exhaustive]
pub enum Prediction<'a> {
    /// A file.
    File(ArrayFile),
    /// Values in memory, of shape (samples, bins).
    Values {
        /// The values, row by row.
        values: &'a [f32],
        /// Length of a row.
        bins: usize,
    },
}

impl Prediction<'_> {
    /// Samples and bins.
    pub fn shape(&self) -> Shape {
        match self {
            Self::File(file) => file.shape(),
            Self::Values { values, bins } => Shape {
                samples: values.len() / (*bins).max(1),
                bins: *bins,
            },
        }
    }

    fn name(&self) -> String {
        match self {
            Self::File(file) => format!("'{}'", file.path().display()),
            Self::Values { .. } => "in memory".into(),
        }
    }

    /// Replaces `rows` by the next rows.
    fn read(&mut self, count: usize, rows: &mut Vec<f64>) -> Result<()> {
        match self {
            Self::File(file) => file.read_rows(count, rows),
            Self::Values { values, bins } => {
                let (next, rest) = values.split_at(count * *bins);
                *values = rest;
                rows.clear();
                rows.extend(next.iter().copied().map(f64::from));
                Ok(())
            }
        }
    }
}

/// Settings of a comparison.
#[derive(Debug, Default)]
pub struct Scoring {
    /// Definition of the metrics; otherwise that of the labels, and `paper` for files.
    pub protocol: Option<Protocol>,
    /// Map of each sample; a data set knows its own.
    pub map_ids: Option<ArrayFile>,
    /// Range of the truth that PSNR is relative to; otherwise largest minus smallest true value.
    pub data_range: Option<DataRange>,
}

/// Scores of a prediction.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Scores {
    /// Definition of the metrics.
    pub protocol: aps_metrics::Protocol,
    /// Scores of each sample, and the samples that cannot be scored.
    pub evaluation: Evaluation,
    /// Means, deviations and quantiles, overall and of each map.
    pub report: Report,
}

impl Scoring {
    /// The protocol by which a prediction for this truth is scored.
    pub fn protocol(&self, truth: &Truth) -> Protocol {
        let own = truth.own_protocol();
        self.protocol.or(own).unwrap_or_default()
    }

    /// Scores a prediction. Samples with NaN or an infinity are in no mean, but in [`Evaluation::rejected`].
    ///
    /// # Errors
    /// Files that cannot be read, shapes that differ, a prediction file beside which [other links](links_file) are named, truth without a sample or with none that can be scored.
    pub fn score(self, truth: &mut Truth, mut prediction: Prediction<'_>) -> Result<Scores> {
        let protocol = self.protocol(truth);
        let shape = truth.shape();
        if shape.samples == 0 {
            return Err(ScoreError::NoSample(truth.to_string()).into());
        }
        if let Prediction::Values { values, bins } = &prediction {
            Spectra::new(values, *bins)?;
        }
        if prediction.shape() != shape {
            let what = format!("{truth}, prediction {}", prediction.name());
            return Err(MetricsError::ShapeMismatch {
                truth: shape,
                prediction: prediction.shape(),
            })
            .at(Place::Comparison(what));
        }
        if let (Truth::Dataset(labels), Prediction::File(file)) = (&*truth, &prediction) {
            labels.check_links(file.path())?;
        }
        let mut map_ids = self.map_ids;
        let ids = map_ids.as_ref().map(|file| file.shape().samples);
        if let Some(ids) = ids.filter(|&ids| ids != shape.samples) {
            let samples = shape.samples;
            return Err(MetricsError::MapIds { ids, samples }.into());
        }
        truth.prepare(protocol)?;
        let protocol = aps_metrics::Protocol::from(protocol);
        let mut evaluation = Evaluation::new(protocol);
        let mut predicted = Vec::new();
        truth.for_each_block(BLOCK_VALUES, |true_rows, map_id| {
            let rows = true_rows.len() / shape.bins;
            prediction.read(rows, &mut predicted)?;
            let ids = match (map_id, &mut map_ids) {
                (Some(id), _) => Some(vec![id; rows]),
                (None, Some(file)) => Some(file.read_ids(rows)?),
                (None, None) => None,
            };
            let truth = Spectra::new(true_rows, shape.bins)?;
            let predicted = Spectra::new(&predicted, shape.bins)?;
            Ok(evaluation.push(truth, predicted, ids.as_deref())?)
        })?;
        if evaluation.scored().is_empty() {
            let samples = evaluation.samples();
            let first = evaluation.rejected()[0].defect;
            return Err(ScoreError::NoneScored { samples, first }.into());
        }
        let range = self.data_range.or(evaluation.truth_range());
        let range = range.expect("a scored sample has a finite truth");
        Ok(Scores {
            protocol,
            report: evaluation.report(range),
            evaluation,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_truth_serves_any_number_of_predictions() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("truth.npy");
        let values = [0.0_f32, 1.0, 0.0, 0.5, 0.0, 2.0];
        aps_data::npy::write(&path, &[2, 3], &values).unwrap();
        let mut truth = Truth::File(ArrayFile::open_spectra(&path).unwrap());
        for _ in 0..2 {
            let values = &values;
            let prediction = Prediction::Values { values, bins: 3 };
            let scores = Scoring::default().score(&mut truth, prediction).unwrap();
            let mae = scores.report.overall.get(aps_metrics::Metric::Mae);
            assert_eq!(mae.map(|mae| mae.mean), Some(0.0));
        }
    }
}
