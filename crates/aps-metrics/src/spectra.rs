//! Views of spectra: slices of `f32` or `f64`, one row a sample.

use crate::error::{Error, MAX_MAGNITUDE, Shape};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A number a spectrum may be stored in: `f32` or `f64`. All computation is in `f64`.
pub trait Real: sealed::Sealed + Copy + Into<f64> + Send + Sync {}
impl Real for f32 {}
impl Real for f64 {}

/// A borrowed, row-major array of spectra, shape (samples, bins).
#[derive(Debug, Clone, Copy)]
pub struct Spectra<'a, T> {
    values: &'a [T],
    bins: usize,
}

impl<'a, T: Real> Spectra<'a, T> {
    /// Views `values` as rows of `bins` numbers.
    ///
    /// # Errors
    /// [`Error::NoBins`] if `bins` is 0, [`Error::IncompleteRow`] if the rows do not come out even.
    pub fn new(values: &'a [T], bins: usize) -> Result<Self, Error> {
        if bins == 0 {
            return Err(Error::NoBins);
        }
        if !values.len().is_multiple_of(bins) {
            return Err(Error::IncompleteRow {
                values: values.len(),
                bins,
            });
        }
        Ok(Self { values, bins })
    }

    /// Number of spectra and of bins.
    pub fn shape(&self) -> Shape {
        Shape {
            samples: self.values.len() / self.bins,
            bins: self.bins,
        }
    }

    /// The spectrum of one sample.
    ///
    /// # Panics
    /// If `sample` is not below the number of samples.
    pub fn row(&self, sample: usize) -> &'a [T] {
        &self.values[sample * self.bins..(sample + 1) * self.bins]
    }
}

/// Index of the first value no metric is defined on.
pub(crate) fn first_defect(values: &[f64]) -> Option<usize> {
    // NaN fails the comparison too. The fold without an early exit vectorises; the search
    // runs only for the rare spectrum that has something to find.
    let sound = |v: &f64| v.abs() <= MAX_MAGNITUDE;
    let all_sound = values.iter().fold(true, |all, v| all & sound(v));
    if all_sound {
        None
    } else {
        values.iter().position(|v| !sound(v))
    }
}
