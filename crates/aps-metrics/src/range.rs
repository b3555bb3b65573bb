//! Range of the data, to which PSNR is relative.

use crate::error::Error;
use crate::pointwise::{maximum, minimum};

/// Smallest data range, as in the released code; keeps PSNR finite on a constant test set.
const MIN_RANGE: f64 = 1e-6;

/// Peak-to-peak range of the truth, in the unit of the spectra: positive and finite.
///
/// PSNR compares runs only if they share it. Either give the number a published result states,
/// or take [`crate::Evaluation::truth_range`] of the whole test set.
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
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct RangeScan {
    bounds: Option<(f64, f64)>,
}

impl RangeScan {
    /// A scan of values that are finite, at least one.
    pub fn of(values: &[f64]) -> Self {
        let bounds = Some((minimum(values), maximum(values)));
        Self { bounds }
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

    /// Maximum of all values; `None` before the first value.
    pub fn maximum(&self) -> Option<f64> {
        self.bounds.map(|(_, high)| high)
    }

    /// Maximum - minimum of all values, at least 1e-6; `None` before the first value.
    pub fn range(&self) -> Option<DataRange> {
        self.bounds
            .map(|(low, high)| DataRange((high - low).max(MIN_RANGE)))
    }
}
