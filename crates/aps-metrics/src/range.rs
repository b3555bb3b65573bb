//! Range of the data, to which PSNR is relative.

use crate::error::Error;
use crate::pointwise::{maximum, minimum};
use crate::spectra::{MAX_MAGNITUDE, Real};

/// Smallest data range, as in the released code; keeps PSNR finite on a constant test set.
const MIN_RANGE: f64 = 1e-6;

/// Peak-to-peak range of the truth, in the unit of the spectra: positive and finite.
///
/// PSNR compares runs only if they share it. Either give the number a published result states,
/// or scan the truth of the whole test set with a [`RangeScan`].
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct DataRange(f64);

impl DataRange {
    /// A known range.
    ///
    /// # Errors
    /// [`Error::DataRange`] unless `range` is positive and finite.
    pub fn new(range: f64) -> Result<Self, Error> {
        if range > 0.0 && range.is_finite() {
            Ok(Self(range))
        } else {
            Err(Error::DataRange(range))
        }
    }

    /// The range, in the unit of the spectra.
    pub fn get(self) -> f64 {
        self.0
    }
}

/// Largest and smallest value of the truth so far. Mergeable, in any order.
///
/// ```
/// use aps_metrics::RangeScan;
///
/// let mut scan = RangeScan::default();
/// scan.observe(&[0.5_f32, -1.0])?;
/// scan.observe(&[3.0_f32])?;
/// assert_eq!(scan.range().map(|range| range.get()), Some(4.0));
/// # Ok::<(), aps_metrics::Error>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RangeScan {
    bounds: Option<(f64, f64)>,
}

impl RangeScan {
    /// Takes the values of one or more true spectra into account.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if one is NaN, infinite or beyond [`MAX_MAGNITUDE`]; nothing of
    /// `values` is then taken into account.
    pub fn observe<T: Real>(&mut self, values: &[T]) -> Result<(), Error> {
        let sound = |v: &T| v.to_f64().abs() <= MAX_MAGNITUDE;
        if let Some(index) = values.iter().position(|v| !sound(v)) {
            return Err(Error::NotFinite { index });
        }
        let values: Vec<f64> = values.iter().map(|v| v.to_f64()).collect();
        self.merge(scan_finite(&values));
        Ok(())
    }

    /// Takes everything `other` has seen into account.
    pub fn merge(&mut self, other: Self) {
        self.bounds = match (self.bounds, other.bounds) {
            (Some((low, high)), Some((other_low, other_high))) => {
                Some((low.min(other_low), high.max(other_high)))
            }
            (mine, theirs) => mine.or(theirs),
        };
    }

    /// Maximum - minimum of all values, at least 1e-6; `None` before the first value.
    pub fn range(&self) -> Option<DataRange> {
        self.bounds
            .map(|(low, high)| DataRange((high - low).max(MIN_RANGE)))
    }
}

/// A scan of values already known to be finite.
pub(crate) fn scan_finite(values: &[f64]) -> RangeScan {
    let bounds = (!values.is_empty()).then(|| (minimum(values), maximum(values)));
    RangeScan { bounds }
}
