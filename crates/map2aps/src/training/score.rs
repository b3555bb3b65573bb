//! Scores of predictions of the development links.

use aps_metrics::{Evaluation, GroupReport, Spectra};
use aps_model::condition::ModelInput;
use aps_model::train::predict;
use aps_model::{ANGLE_BINS, Model};
use rayon::prelude::*;

use crate::error::Result;
use crate::examples::Examples;
use crate::scores::ScoreError;

/// Spectra scored at a time, and labels summed by one thread; fixed, so that the sum does not depend on the threads.
const BLOCK: usize = 1024;

/// The links by which the best weights are chosen.
#[derive(Debug)]
pub struct Development {
    /// The links.
    pub examples: Examples,
    /// Input of the model for them.
    pub input: Box<dyn ModelInput>,
    /// Definition of the metrics: that of the labels.
    pub protocol: aps_metrics::Protocol,
}

impl Development {
    /// Scores of a model.
    pub fn score(&self, model: &dyn Model, batch: usize) -> Result<GroupReport> {
        let mut evaluation = Evaluation::new(self.protocol);
        let links = self.examples.links();
        predict(model, &*self.input, links, batch, |first, spectra| {
            self.examples.push_scores(&mut evaluation, first, spectra)
        })?;
        report(&evaluation)
    }

    /// Scores of predicting the same for every link.
    pub fn score_constant(&self, spectrum: &[f64]) -> Result<GroupReport> {
        let mut evaluation = Evaluation::new(self.protocol);
        let spectrum: Vec<f32> = spectrum.iter().map(|&x| x as f32).collect();
        let repeated = spectrum.repeat(BLOCK);
        let links = self.examples.list().len();
        for first in (0..links).step_by(BLOCK) {
            let rows = &repeated[..BLOCK.min(links - first) * ANGLE_BINS];
            self.examples.push_scores(&mut evaluation, first, rows)?;
        }
        report(&evaluation)
    }
}

fn report(evaluation: &Evaluation) -> Result<GroupReport> {
    let range = evaluation.truth_range();
    let none = || ScoreError::NoSample("the part of the development maps".into());
    Ok(evaluation.report(range.ok_or_else(none)?).overall)
}

impl Examples {
    /// Scores the spectra that are predicted for all examples, shape (examples, [`ANGLE_BINS`]).
    ///
    /// # Errors
    /// Values that are no whole spectra.
    ///
    /// # Panics
    /// As [`Examples::target`], and for more spectra than examples.
    pub fn evaluate(
        &self,
        predicted: &[f32],
        protocol: aps_metrics::Protocol,
    ) -> Result<Evaluation> {
        let mut evaluation = Evaluation::new(protocol);
        for (block, rows) in predicted.chunks(BLOCK * ANGLE_BINS).enumerate() {
            self.push_scores(&mut evaluation, block * BLOCK, rows)?;
        }
        Ok(evaluation)
    }

    /// Scores the spectra that are predicted for the examples from `first` on.
    fn push_scores(
        &self,
        evaluation: &mut Evaluation,
        first: usize,
        predicted: &[f32],
    ) -> Result<()> {
        let rows = predicted.len() / ANGLE_BINS;
        let target = |i: usize| self.target(first + i);
        let truth: Vec<f64> = (0..rows).into_par_iter().flat_map_iter(target).collect();
        let (truth, predicted) = (
            Spectra::new(&truth, ANGLE_BINS)?,
            Spectra::new(predicted, ANGLE_BINS)?,
        );
        Ok(evaluation.push(truth, predicted, None)?)
    }

    /// The mean of the targets, zeros without any: the best prediction by someone who knows no map and no position.
    ///
    /// The same bits for any number of threads.
    ///
    /// # Panics
    /// As [`Examples::target`].
    pub fn mean_target(&self) -> Vec<f64> {
        let n = self.list().len();
        let sums: Vec<[f64; ANGLE_BINS]> = (0..n.div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| {
                let mut sum = [0.0; ANGLE_BINS];
                for link in block * BLOCK..n.min((block + 1) * BLOCK) {
                    add(&mut sum, &self.target(link));
                }
                sum
            })
            .collect();
        let mut total = vec![0.0; ANGLE_BINS];
        sums.iter().for_each(|sum| add(&mut total, sum));
        total.iter_mut().for_each(|x| *x /= n.max(1) as f64);
        total
    }
}

fn add(sum: &mut [f64], values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(s, v)| *s += v);
}
