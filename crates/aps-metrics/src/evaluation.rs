//! Scores of a test set, gathered chunk by chunk.

use rayon::prelude::*;

use crate::error::{Defect, Error};
use crate::metric::Metric;
use crate::protocol::Definition;
use crate::range::{DataRange, RangeScan};
use crate::sample::{SampleScores, Scorer};
use crate::spectra::{Real, Spectra};

/// Rows scored before their results are moved into place: bounds the working memory.
const BLOCK: usize = 16_384;

/// Fewest rows handed to a thread at once.
const MIN_ROWS: usize = 64;

/// One scored sample.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct ScoredSample {
    /// Row of the sample in everything pushed so far, rejected samples counted.
    pub sample: usize,
    /// Map of the sample, if stated.
    pub map_id: Option<u32>,
    /// Scores of the sample.
    pub scores: SampleScores,
}

/// One sample that could not be scored.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RejectedSample {
    /// Row of the sample in everything pushed so far.
    pub sample: usize,
    /// Map of the sample, if stated.
    pub map_id: Option<u32>,
    /// Reason for the rejection.
    pub defect: Defect,
}

/// Scores of a test set that may be larger than memory: push it in chunks. 120 bytes are kept a
/// sample (30 MB for 250,000), so that quantiles are exact.
///
/// Samples are scored in parallel on rayon's current pool. The result depends only on the
/// samples and their order: any number of threads and any cut into chunks gives the same bytes.
///
/// ```
/// use aps_metrics::{Evaluation, Protocol, Spectra};
///
/// let (truth, prediction) = ([0.0_f32, 3.0, 1.0, 0.0], [0.0_f32, 2.0, f32::NAN, 0.0]);
/// let mut evaluation = Evaluation::new(Protocol::Released);
/// evaluation.push(Spectra::new(&truth, 4)?, Spectra::new(&truth, 4)?, Some(&[46]))?;
/// evaluation.push(Spectra::new(&truth, 4)?, Spectra::new(&prediction, 4)?, Some(&[47]))?;
/// assert_eq!(evaluation.samples(), 2);
/// assert_eq!(evaluation.rejected()[0].map_id, Some(47)); // told, not averaged
/// # Ok::<(), aps_metrics::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    definition: Definition,
    bins: Option<usize>,
    scored: Vec<ScoredSample>,
    rejected: Vec<RejectedSample>,
    truth: RangeScan,
}

impl Evaluation {
    /// An empty evaluation under a [`crate::Protocol`] or a [`Definition`] of one's own.
    pub fn new(definition: impl Into<Definition>) -> Self {
        Self {
            definition: definition.into(),
            bins: None,
            scored: Vec::new(),
            rejected: Vec::new(),
            truth: RangeScan::default(),
        }
    }

    /// Scores a chunk of predictions against the truth, row by row; `map_ids` has shape
    /// (samples) and lets the report tell maps apart.
    ///
    /// A row that holds NaN, an infinity or a value beyond [`crate::MAX_MAGNITUDE`] is not an
    /// error: it is listed in [`Self::rejected`] and in no mean. Look there before you trust a
    /// mean.
    ///
    /// # Errors
    /// [`Error::ShapeMismatch`], [`Error::BinsChanged`], [`Error::MapIds`]; nothing is then
    /// scored.
    pub fn push<T: Real, P: Real>(
        &mut self,
        truth: Spectra<'_, T>,
        prediction: Spectra<'_, P>,
        map_ids: Option<&[u32]>,
    ) -> Result<(), Error> {
        let shape = truth.shape();
        if shape != prediction.shape() {
            return Err(Error::ShapeMismatch {
                truth: shape,
                prediction: prediction.shape(),
            });
        }
        if let Some(ids) = map_ids.filter(|ids| ids.len() != shape.samples) {
            return Err(Error::MapIds {
                ids: ids.len(),
                samples: shape.samples,
            });
        }
        self.set_bins(shape.bins)?;

        self.scored.reserve(shape.samples);
        let mut rows = Vec::new();
        for start in (0..shape.samples).step_by(BLOCK) {
            let end = shape.samples.min(start + BLOCK);
            let first = self.samples();
            (start..end)
                .into_par_iter()
                .with_min_len(MIN_ROWS)
                .map_init(
                    || Scorer::new(self.definition),
                    |scorer, row| scorer.score_row(truth.row(row), prediction.row(row)),
                )
                .collect_into_vec(&mut rows);
            for (offset, row) in rows.drain(..).enumerate() {
                let sample = first + offset;
                let map_id = map_ids.map(|ids| ids[start + offset]);
                self.truth.merge(row.truth_range);
                match row.scores {
                    Ok(scores) => self.scored.push(ScoredSample {
                        sample,
                        map_id,
                        scores,
                    }),
                    Err(defect) => {
                        self.rejected.push(RejectedSample {
                            sample,
                            map_id,
                            defect,
                        });
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns the definition of the metrics that the samples are scored under.
    pub fn definition(&self) -> &Definition {
        &self.definition
    }

    /// Number of samples pushed, rejected ones included.
    pub fn samples(&self) -> usize {
        self.scored.len() + self.rejected.len()
    }

    /// The scored samples in the order they were pushed.
    pub fn scored(&self) -> &[ScoredSample] {
        &self.scored
    }

    /// The samples that could not be scored, in the order they were pushed.
    pub fn rejected(&self) -> &[RejectedSample] {
        &self.rejected
    }

    /// Returns the range of all finite true spectra pushed so far, also of samples with a rejected
    /// prediction: the data range of PSNR once the whole test set has been pushed. `None` if there
    /// are none. PSNR is a shift of the stored squared error, so one pass is enough.
    pub fn truth_range(&self) -> Option<DataRange> {
        self.truth.range()
    }

    /// Returns the largest of all finite true values pushed so far; `None` if there was none. Where it is not above 0 the spectra
    /// seem to be in decibels. Metrics of decibels mean nothing.
    pub fn truth_maximum(&self) -> Option<f64> {
        self.truth.maximum()
    }

    /// One metric of each scored sample.
    pub fn column(&self, metric: Metric, range: DataRange) -> Vec<f64> {
        self.scored
            .iter()
            .map(|s| metric.of(&s.scores, range))
            .collect()
    }

    fn set_bins(&mut self, found: usize) -> Result<(), Error> {
        match self.bins {
            Some(expected) if expected != found => Err(Error::BinsChanged { expected, found }),
            _ => {
                self.bins = Some(found);
                Ok(())
            }
        }
    }
}
