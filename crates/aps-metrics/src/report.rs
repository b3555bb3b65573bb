//! Report of an evaluation: the distribution of every metric, overall and for each map.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::distribution::Distribution;
use crate::error::Side;
use crate::evaluation::{Evaluation, ScoredSample};
use crate::metric::Metric;
use crate::protocol::Definition;
use crate::range::DataRange;

/// The result of an [`Evaluation`].
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Report {
    /// Definition of the metrics that the samples were scored under.
    pub definition: Definition,
    /// Range of the data for PSNR, in the unit of the spectra.
    pub data_range: DataRange,
    /// Samples not scored because of their truth. They are in no mean.
    pub rejected_truths: usize,
    /// Samples not scored because of their prediction. They are in no mean.
    pub rejected_predictions: usize,
    /// Metrics over all scored samples.
    pub overall: GroupReport,
    /// Metrics over the scored samples of each map that has any, by rising id.
    pub maps: Vec<MapReport>,
}

/// Metrics over the scored samples of one map.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct MapReport {
    /// Number of the map.
    pub map_id: u32,
    /// Metrics over the samples of the map.
    pub group: GroupReport,
}

/// Metrics over a group of scored samples.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct GroupReport {
    /// Number of samples.
    pub samples: usize,
    /// Distributions of [`Metric::ALL`] in that order; empty if there are no samples.
    pub metrics: Vec<MetricReport>,
    /// Counts of peaks, and of samples with few or none.
    pub peaks: PeakCensus,
}

/// Distribution of one metric over a group of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct MetricReport {
    /// The metric.
    pub metric: Metric,
    /// Distribution of the metric over the samples.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub distribution: Distribution,
}

/// Counts of peaks over a group of samples. Samples without peaks enter the peak metrics by
/// convention, so a report says how many there are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PeakCensus {
    /// Dominant true peaks of all samples together.
    pub dominant_true_peaks: usize,
    /// Samples with at most two dominant true peaks.
    pub at_most_two: usize,
    /// Samples whose truth has no peak.
    pub truths_without_peak: usize,
    /// Samples whose prediction has no peak.
    pub predictions_without_peak: usize,
}

impl GroupReport {
    /// Returns the distribution of a metric; `None` if the group has no samples.
    pub fn get(&self, metric: Metric) -> Option<&Distribution> {
        self.metrics
            .iter()
            .find(|m| m.metric == metric)
            .map(|m| &m.distribution)
    }

    /// Returns the mean of a metric; `None` if the group has no samples.
    pub fn mean(&self, metric: Metric) -> Option<f64> {
        Some(self.get(metric)?.mean)
    }
}

impl PeakCensus {
    fn of<'a>(samples: impl Iterator<Item = &'a ScoredSample>) -> Self {
        let mut census = Self::default();
        for ScoredSample { scores, .. } in samples {
            census.dominant_true_peaks += scores.truth_peaks as usize;
            census.at_most_two += usize::from(scores.truth_peaks <= 2);
            census.truths_without_peak += usize::from(scores.truth_peaks == 0);
            census.predictions_without_peak += usize::from(scores.predicted_peaks == 0);
        }
        census
    }
}

impl Evaluation {
    /// Summarises what has been pushed. `range` is given or [`Evaluation::truth_range`].
    ///
    /// O(samples) a metric, metrics in parallel.
    pub fn report(&self, range: DataRange) -> Report {
        let scored = self.scored();
        let mut rows_of_map: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (row, sample) in scored.iter().enumerate() {
            if let Some(id) = sample.map_id {
                rows_of_map.entry(id).or_default().push(row);
            }
        }
        // By metric: the distribution over the samples of each map, then over all.
        let distributions = |metric: Metric| {
            let column = self.column(metric, range);
            let of_map = |rows: &Vec<usize>| rows.iter().map(|&row| column[row]).collect();
            let of_maps = rows_of_map.values().map(of_map).map(Distribution::of);
            let mut distributions: Vec<_> = of_maps.collect();
            distributions.push(Distribution::of(column));
            distributions
        };
        let all: Vec<_> = Metric::ALL.into_par_iter().map(distributions).collect();
        let metrics = |group: usize| {
            let all = Metric::ALL.into_iter().zip(&all);
            let reports = all.filter_map(|(metric, of_groups)| {
                of_groups[group].map(|distribution| MetricReport {
                    metric,
                    distribution,
                })
            });
            reports.collect()
        };

        let maps = rows_of_map
            .iter()
            .enumerate()
            .map(|(place, (&map_id, rows))| MapReport {
                map_id,
                group: GroupReport {
                    samples: rows.len(),
                    metrics: metrics(place),
                    peaks: PeakCensus::of(rows.iter().map(|&row| &scored[row])),
                },
            });
        let rejected = |side| {
            let rejected = self.rejected().iter();
            rejected.filter(|r| r.defect.side == side).count()
        };
        Report {
            definition: *self.definition(),
            data_range: range,
            rejected_truths: rejected(Side::Truth),
            rejected_predictions: rejected(Side::Prediction),
            overall: GroupReport {
                samples: scored.len(),
                metrics: metrics(rows_of_map.len()),
                peaks: PeakCensus::of(scored.iter()),
            },
            maps: maps.collect(),
        }
    }
}
