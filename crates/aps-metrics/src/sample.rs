//! The scores of one sample.

use crate::angle::AngleDistance;
use crate::dominant::{PeakSearch, SpectrumPeaks};
use crate::error::{Defect, Error, Shape, Side};
use crate::peaks::Peak;
use crate::pointwise::Sums;
use crate::protocol::{Definition, RecallCandidates, TOLERANCES_DEG};
use crate::range::{DataRange, RangeScan};
use crate::spectra::{Real, first_defect};

/// Floor of the squared error, of the truth's mean square and of NMSE, before a logarithm or a
/// division.
const POWER_FLOOR: f64 = 1e-12;

/// Floor of the squared norm in the cosine: 1e-8 squared, PyTorch's.
const SQUARED_NORM_FLOOR: f64 = 1e-16;

/// PLE of a sample with true peaks and no predicted one \[deg\].
const MISSED_PLE_DEG: f64 = 180.0;

/// Stored scores of one sample. Methods compute the metrics that follow from them;
/// [`crate::Metric::of`] gives every metric by name. Every number is finite.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SampleScores {
    /// Mean over bins of |truth - prediction|, in the unit of the spectra.
    pub mae: f64,
    /// Mean over bins of (truth - prediction)^2.
    pub mse: f64,
    /// `mse` over the mean of truth^2, the latter at least 1e-12; linear.
    pub nmse: f64,
    /// Cosine similarity in \[-1, 1\]; norms at least 1e-8 each, so 0 for an all-zero spectrum.
    pub cosine: f64,
    /// Peak location error \[deg\]: mean over the dominant true peaks of the distance to the
    /// nearest predicted peak. 0 without a true peak, else 180 without a predicted one.
    pub ple_deg: f64,
    /// `ple_deg` with the distance to the nearer of a predicted peak and its mirror twin.
    pub mirror_ple_deg: f64,
    /// Distance between the strongest true and the strongest predicted peak \[deg\]; `None` if
    /// either side has no peak, which is never a hit.
    pub top_error_deg: Option<f64>,
    /// `top_error_deg` to the nearer of the strongest predicted peak and its mirror twin.
    pub mirror_top_error_deg: Option<f64>,
    /// Share of the dominant true peaks with a predicted peak within each of
    /// [`TOLERANCES_DEG`], in \[0, 1\]. 1 without a true peak.
    pub recall: [f64; 2],
    /// Number of dominant true peaks.
    pub truth_peaks: u32,
    /// Number of predicted peaks, dominant or not.
    pub predicted_peaks: u32,
}

impl SampleScores {
    /// Root of `mse`, in the unit of the spectra.
    pub fn rmse(&self) -> f64 {
        self.mse.sqrt()
    }

    /// 10 log10 of `nmse`, at least -120 \[dB\].
    pub fn nmse_db(&self) -> f64 {
        10.0 * self.nmse.max(POWER_FLOOR).log10()
    }

    /// 20 log10(range) - 10 log10(mse) with `mse` at least 1e-12 \[dB\].
    pub fn psnr_db(&self, range: DataRange) -> f64 {
        20.0 * range.get().log10() - 10.0 * self.mse.max(POWER_FLOOR).log10()
    }

    /// Angle between truth and prediction as vectors, in \[0, 180\] \[deg\].
    pub fn spectral_angle_deg(&self) -> f64 {
        self.cosine.acos().to_degrees()
    }

    /// Returns true when the strongest peaks are at most `delta_deg` apart.
    pub fn hit(&self, delta_deg: f64) -> bool {
        self.top_error_deg.is_some_and(|error| error <= delta_deg)
    }

    /// [`Self::hit`] that also accepts the mirror twin of the predicted peak.
    pub fn mirror_hit(&self, delta_deg: f64) -> bool {
        self.mirror_top_error_deg
            .is_some_and(|error| error <= delta_deg)
    }
}

/// Scores one sample at a time with buffers it keeps; O(bins) a sample.
///
/// ```
/// use aps_metrics::{Protocol, Scorer};
///
/// let mut scorer = Scorer::new(Protocol::Paper);
/// let truth = [0.0_f32, 4.0, 0.0, 0.0, 0.0, 0.0];
/// let prediction = [0.0_f32, 0.0, 4.0, 0.0, 0.0, 0.0];
/// let scores = scorer.score(&truth, &prediction)?;
/// assert_eq!(scores.ple_deg, 60.0); // one bin of six
/// assert!(!scores.hit(2.0));
/// assert_eq!(scores.cosine, 0.0);
/// # Ok::<(), aps_metrics::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Scorer {
    definition: Definition,
    truth: Vec<f64>,
    prediction: Vec<f64>,
    search: PeakSearch,
    truth_peaks: SpectrumPeaks,
    predicted_peaks: SpectrumPeaks,
}

impl Scorer {
    /// A scorer under a [`crate::Protocol`] or a [`Definition`] of one's own.
    pub fn new(definition: impl Into<Definition>) -> Self {
        Self {
            definition: definition.into(),
            truth: Vec::new(),
            prediction: Vec::new(),
            search: PeakSearch::default(),
            truth_peaks: SpectrumPeaks::default(),
            predicted_peaks: SpectrumPeaks::default(),
        }
    }

    /// Scores a predicted spectrum, shape (bins), against the true one.
    ///
    /// # Errors
    /// [`Error::ShapeMismatch`] for different lengths, [`Error::NoBins`] for empty spectra,
    /// [`Error::Unscorable`] if a value is NaN, infinite or beyond [`crate::MAX_MAGNITUDE`].
    pub fn score<T: Real, P: Real>(
        &mut self,
        truth: &[T],
        prediction: &[P],
    ) -> Result<SampleScores, Error> {
        if truth.len() != prediction.len() {
            let shape = |bins| Shape { samples: 1, bins };
            return Err(Error::ShapeMismatch {
                truth: shape(truth.len()),
                prediction: shape(prediction.len()),
            });
        }
        if truth.is_empty() {
            return Err(Error::NoBins);
        }
        self.score_row(truth, prediction)
            .scores
            .map_err(Error::Unscorable)
    }

    /// Scores two rows of the same, positive length.
    pub(crate) fn score_row<T: Real, P: Real>(&mut self, truth: &[T], prediction: &[P]) -> Row {
        self.truth.clear();
        self.truth.extend(truth.iter().map(|&v| v.into()));
        self.prediction.clear();
        let prediction = prediction.iter().map(|&v| v.into());
        self.prediction.extend(prediction);

        let defect = |side: Side, values: &[f64]| match first_defect(values) {
            Some(bin) => Err(Defect { side, bin }),
            None => Ok(()),
        };
        if let Err(defect) = defect(Side::Truth, &self.truth) {
            return Row {
                truth_range: RangeScan::default(),
                scores: Err(defect),
            };
        }
        Row {
            truth_range: RangeScan::of(&self.truth),
            scores: defect(Side::Prediction, &self.prediction).map(|()| self.score_finite()),
        }
    }

    fn score_finite(&mut self) -> SampleScores {
        let bins = self.truth.len();
        self.search
            .run(&self.truth, &self.definition, &mut self.truth_peaks);
        self.search.run(
            &self.prediction,
            &self.definition,
            &mut self.predicted_peaks,
        );
        let angles = AngleDistance::new(&self.definition, bins);

        let truth = self.truth_peaks.dominant();
        let predicted = self.predicted_peaks.all();
        let recallable = match self.definition.recall_candidates {
            RecallCandidates::AllPeaks => predicted,
            RecallCandidates::DominantPeaks => self.predicted_peaks.dominant(),
        };
        let plain = |a, b| angles.distance(a, b);
        let mirrored = |a, b| angles.mirror_distance(a, b);
        let tops = self
            .truth_peaks
            .strongest()
            .zip(self.predicted_peaks.strongest());

        let sums = Sums::of(&self.truth, &self.prediction);
        let count = bins as f64;
        let mse = sums.squared_error / count;
        // One root of the product, so that identical spectra have cosine 1 exactly.
        let norms = (sums.truth_power.max(SQUARED_NORM_FLOOR)
            * sums.prediction_power.max(SQUARED_NORM_FLOOR))
        .sqrt();
        SampleScores {
            mae: sums.absolute_error / count,
            mse,
            nmse: mse / (sums.truth_power / count).max(POWER_FLOOR),
            cosine: (sums.product / norms).clamp(-1.0, 1.0),
            ple_deg: mean_error_deg(truth, predicted, &angles, plain),
            mirror_ple_deg: mean_error_deg(truth, predicted, &angles, mirrored),
            top_error_deg: tops.map(|(t, p)| angles.degrees(plain(t.bin, p.bin))),
            mirror_top_error_deg: tops.map(|(t, p)| angles.degrees(mirrored(t.bin, p.bin))),
            recall: TOLERANCES_DEG.map(|delta| recall(truth, recallable, &angles, delta)),
            truth_peaks: truth.len() as u32,
            predicted_peaks: predicted.len() as u32,
        }
    }
}

/// Outcome of one row.
pub(crate) struct Row {
    /// Range of the truth; empty if that is not finite.
    pub truth_range: RangeScan,
    pub scores: Result<SampleScores, Defect>,
}

/// Smallest distance in half bins from `bin` to one of `peaks`.
fn nearest(bin: usize, peaks: &[Peak], distance: impl Fn(usize, usize) -> usize) -> Option<usize> {
    peaks.iter().map(|peak| distance(bin, peak.bin)).min()
}

fn mean_error_deg(
    truth: &[Peak],
    predicted: &[Peak],
    angles: &AngleDistance,
    distance: impl Fn(usize, usize) -> usize + Copy,
) -> f64 {
    if truth.is_empty() {
        return 0.0;
    }
    let total: Option<usize> = truth
        .iter()
        .map(|t| nearest(t.bin, predicted, distance))
        .sum();
    total.map_or(MISSED_PLE_DEG, |half_bins| {
        angles.degrees(half_bins) / truth.len() as f64
    })
}

fn recall(truth: &[Peak], predicted: &[Peak], angles: &AngleDistance, delta_deg: f64) -> f64 {
    if truth.is_empty() {
        return 1.0;
    }
    let found = truth.iter().filter(|t| {
        nearest(t.bin, predicted, |a, b| angles.distance(a, b))
            .is_some_and(|half_bins| angles.degrees(half_bins) <= delta_deg)
    });
    found.count() as f64 / truth.len() as f64
}
