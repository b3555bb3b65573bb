//! Peaks of a scaled spectrum and the dominant ones among them.

use crate::error::Error;
use crate::peaks::{Peak, PeakFinder, Topology};
use crate::pointwise::maximum;
use crate::protocol::{AngleGrid, Definition, PeakScaling};
use crate::spectra::{Real, first_defect};

/// Keeps the sum of peak heights away from 0 when contributions are taken, and the divisor of
/// [`PeakScaling::MaximumPlusEpsilon`]. The released code's value; the paper gives none.
const EPSILON: f64 = 1e-8;

/// Peaks of one spectrum under a [`Definition`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SpectrumPeaks {
    all: Vec<Peak>,
    dominant: Vec<Peak>,
}

impl SpectrumPeaks {
    /// Returns every peak in order of their bins. Heights are those of the spectrum divided as
    /// [`PeakScaling`] says.
    pub fn all(&self) -> &[Peak] {
        &self.all
    }

    /// Returns the dominant peaks in order of their bins: peaks with a height of at least
    /// `min_contribution` of the sum of all heights, or the highest one if none reaches that.
    /// Empty only if there are no peaks.
    pub fn dominant(&self) -> &[Peak] {
        &self.dominant
    }

    /// Returns the highest dominant peak, the first of equally high ones.
    pub fn strongest(&self) -> Option<Peak> {
        first_highest(&self.dominant)
    }

    fn clear(&mut self) {
        self.all.clear();
        self.dominant.clear();
    }
}

/// Finds the peaks of one spectrum; a test set is scored with [`crate::Evaluation`] instead.
///
/// ```
/// use aps_metrics::{Protocol, spectrum_peaks};
///
/// let spectrum = [-0.5, 3.0, -0.5, -0.4, -0.5, 1.0, -0.5_f32];
/// let peaks = spectrum_peaks(&spectrum, &Protocol::Released.definition())?;
/// assert_eq!(peaks.all().len(), 2); // 0.1 / 3 is below the prominence of 0.05
/// assert_eq!(peaks.strongest().map(|peak| peak.bin), Some(1));
/// # Ok::<(), aps_metrics::Error>(())
/// ```
///
/// # Errors
/// [`Error::NoBins`] for an empty spectrum, [`Error::NotFinite`] for a value that is NaN,
/// infinite or beyond [`crate::MAX_MAGNITUDE`].
pub fn spectrum_peaks<T: Real>(
    spectrum: &[T],
    definition: &Definition,
) -> Result<SpectrumPeaks, Error> {
    if spectrum.is_empty() {
        return Err(Error::NoBins);
    }
    let values: Vec<f64> = spectrum.iter().map(|&v| v.into()).collect();
    if let Some(index) = first_defect(&values) {
        let limit = crate::MAX_MAGNITUDE;
        return Err(Error::NotFinite { index, limit });
    }
    let mut peaks = SpectrumPeaks::default();
    PeakSearch::default().run(&values, definition, &mut peaks);
    Ok(peaks)
}

/// Buffers of [`spectrum_peaks`], kept for reuse.
#[derive(Debug, Clone, Default)]
pub(crate) struct PeakSearch {
    finder: PeakFinder,
    scaled: Vec<f64>,
}

impl PeakSearch {
    /// Replaces `peaks` by those of `values`, which must be finite.
    pub fn run(&mut self, values: &[f64], definition: &Definition, peaks: &mut SpectrumPeaks) {
        peaks.clear();
        let maximum = maximum(values);
        let divisor = match definition.peak_scaling {
            PeakScaling::Maximum if maximum > 0.0 => maximum,
            PeakScaling::MaximumPlusEpsilon if maximum + EPSILON != 0.0 => maximum + EPSILON,
            PeakScaling::Maximum | PeakScaling::MaximumPlusEpsilon => return,
        };
        let searched = match (definition.peaks, definition.grid) {
            (Topology::Ring, AngleGrid::Closed) => &values[..values.len().saturating_sub(1)],
            (Topology::Ring, AngleGrid::HalfOpen) | (Topology::Line, _) => values,
        };
        self.scaled.clear();
        // Not a product with the reciprocal: its rounding could make or break a plateau.
        self.scaled.extend(searched.iter().map(|v| v / divisor));
        let found = self
            .finder
            .find(&self.scaled, definition.peaks, definition.min_prominence);
        peaks.all.extend_from_slice(found);

        let total: f64 = found.iter().map(|peak| peak.height).sum();
        let contributes = |p: &&Peak| p.height / (total + EPSILON) >= definition.min_contribution;
        peaks.dominant.extend(found.iter().filter(contributes));
        if peaks.dominant.is_empty() {
            peaks.dominant.extend(first_highest(found));
        }
    }
}

fn first_highest(peaks: &[Peak]) -> Option<Peak> {
    peaks.iter().copied().reduce(|best, peak| {
        if peak.height > best.height {
            peak
        } else {
            best
        }
    })
}
