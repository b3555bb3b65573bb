//! Predictions of any model scored against labels.

use aps_label::Protocol;
use aps_metrics::{DataRange, Error as MetricsError, Evaluation, Report, Shape, Spectra};

use super::{ArrayFile, ScoreError, Truth};
use crate::error::{At, Place, Result};

/// Values of spectra held at a time: 16 MB in f64, beside the scores of 120 bytes a sample.
const BLOCK_VALUES: usize = 1 << 21;

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
    /// Files that cannot be read, shapes that differ, a prediction file beside which [other links](super::links_file) are named, truth without a sample or with none that can be scored.
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
