//! Scores of predictions of the development links.

use std::fmt::Write;

use anyhow::{Context, Result};
use aps_label::Protocol;
use aps_metrics::{Evaluation, GroupReport, Metric, Spectra};
use aps_model::condition::ModelInput;
use aps_model::train::predict;
use aps_model::{ANGLE_BINS, Model};
use rayon::prelude::*;

use crate::labels::Labels;

/// Labels summed by one thread; fixed, so that the sum does not depend on the threads.
pub const BLOCK: usize = 1024;

/// The columns of the closing table beside [`Metric::PAPER_COLUMNS`].
const MSE: [Metric; 1] = [Metric::Mse];

/// The links by which the best weights are chosen.
pub struct Development {
    labels: Labels,
    protocol: aps_metrics::Protocol,
}

impl Development {
    /// Scores by the definitions of the labels' protocol.
    pub fn new(labels: Labels, protocol: Protocol) -> Self {
        Self {
            labels,
            protocol: protocol.into(),
        }
    }

    /// Number of links.
    pub fn len(&self) -> usize {
        self.labels.rows().len()
    }

    /// Scores of a model.
    pub fn score(
        &self,
        model: &dyn Model,
        input: &dyn ModelInput,
        batch: usize,
    ) -> Result<GroupReport> {
        let mut evaluation = Evaluation::new(self.protocol);
        let links = self.labels.links().iter().copied();
        predict(model, input, links, batch, |first, spectra| {
            push(&mut evaluation, &self.labels, first, spectra)
        })?;
        report(&evaluation)
    }

    /// Scores of predicting the same for every link.
    pub fn score_constant(&self, spectrum: &[f64]) -> Result<GroupReport> {
        let mut evaluation = Evaluation::new(self.protocol);
        let repeated: Vec<f32> = spectrum
            .iter()
            .map(|&x| x as f32)
            .collect::<Vec<_>>()
            .repeat(BLOCK);
        for first in (0..self.len()).step_by(BLOCK) {
            let rows = BLOCK.min(self.len() - first);
            push(
                &mut evaluation,
                &self.labels,
                first,
                &repeated[..rows * ANGLE_BINS],
            )?;
        }
        report(&evaluation)
    }
}

/// Scores the spectra that are predicted for the links from `first` on.
pub fn push(
    evaluation: &mut Evaluation,
    labels: &Labels,
    first: usize,
    predicted: &[f32],
) -> Result<()> {
    let rows = predicted.len() / ANGLE_BINS;
    let target = |i: usize| labels.target(first + i);
    let truth: Vec<f64> = (0..rows).into_par_iter().flat_map_iter(target).collect();
    let (truth, predicted) = (
        Spectra::new(&truth, ANGLE_BINS)?,
        Spectra::new(predicted, ANGLE_BINS)?,
    );
    Ok(evaluation.push(truth, predicted, None)?)
}

fn report(evaluation: &Evaluation) -> Result<GroupReport> {
    let range = evaluation
        .truth_range()
        .context("there is no development link")?;
    Ok(evaluation.report(range).overall)
}

/// Mean of a metric; a scored group has one.
pub fn mean(group: &GroupReport, metric: Metric) -> f64 {
    group.get(metric).map_or(f64::NAN, |d| d.mean)
}

/// The mean of the targets: the best prediction by someone who knows no map and no position.
///
/// The same bits for any number of threads.
pub fn mean_spectrum(labels: &Labels) -> Vec<f64> {
    let n = labels.rows().len();
    let sums: Vec<[f64; ANGLE_BINS]> = (0..n.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let mut sum = [0.0; ANGLE_BINS];
            for link in block * BLOCK..n.min((block + 1) * BLOCK) {
                add(&mut sum, &labels.target(link));
            }
            sum
        })
        .collect();
    let mut total = vec![0.0; ANGLE_BINS];
    sums.iter().for_each(|sum| add(&mut total, sum));
    total.iter_mut().for_each(|x| *x /= n as f64);
    total
}

fn add(sum: &mut [f64], values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(s, v)| *s += v);
}

/// Means of the paper's columns, one row a name.
pub fn table(rows: &[(String, &GroupReport)]) -> String {
    let columns = || Metric::PAPER_COLUMNS.into_iter().chain(MSE);
    let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let mut text = format!("{:width$}", "");
    for metric in columns() {
        let unit = match metric.unit() {
            "" => String::new(),
            unit => format!(" [{unit}]"),
        };
        let _ = write!(text, "  {:>10}", format!("{}{unit}", metric.label()));
    }
    for (name, group) in rows {
        let _ = write!(text, "\n{name:width$}");
        for metric in columns() {
            let _ = write!(text, "  {:>10.4}", mean(group, metric));
        }
    }
    text
}
