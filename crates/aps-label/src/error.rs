//! Errors of configurations, of paths, of points of evaluation and of values to normalise.

use crate::limits::{
    MAX_DELAY_POINTS, MAX_DELAY_S, MAX_ELEMENTS, MAX_WAVELENGTHS, SAMPLING_RATE_HZ,
};

/// Reason to refuse a [`LabelConfig`](crate::LabelConfig).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// The sampling rate is not a usable frequency.
    #[error(
        "sampling_rate_hz = {value}: must be between {min:e} and {max:e} Hz",
        min = SAMPLING_RATE_HZ.start(),
        max = SAMPLING_RATE_HZ.end()
    )]
    SamplingRate {
        /// The value given \[Hz\].
        value: f64,
    },
    /// The array has no element, or too many.
    #[error("array of {elements} elements: must be between 1 and {max}", max = MAX_ELEMENTS)]
    Elements {
        /// The number given.
        elements: usize,
    },
    /// A name of no form of array.
    #[error("'{0}' is no form of an array; ula and uca are")]
    ArrayForm(String),
    /// The spacing or the radius of the array is not a usable length.
    #[error(
        "{field} = {value}: must be positive and at most {max} wavelengths",
        max = MAX_WAVELENGTHS
    )]
    Wavelengths {
        /// The field of [`Array`](crate::Array).
        field: &'static str,
        /// The value given \[wavelengths\].
        value: f64,
    },
    /// The delay axis has too few or too many points.
    #[error("delay axis of {points} points: must be between 2 and {max}", max = MAX_DELAY_POINTS)]
    DelayPoints {
        /// The number given.
        points: usize,
    },
    /// The delay axis does not end at a usable delay.
    #[error("delay axis ends at {value} s: must be positive and at most {max} s", max = MAX_DELAY_S)]
    DelayEnd {
        /// The value given \[s\].
        value: f64,
    },
}

/// Reason to refuse a list of paths. The index counts from 0 in the slice given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// A field is NaN or infinite.
    #[error("path {index}: {field} = {value} is not finite; leave the path out or correct it")]
    NotFinite {
        /// Position of the path in the slice.
        index: usize,
        /// Name of the field of [`PathSample`](crate::PathSample).
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// The delay is negative or beyond [`MAX_DELAY_S`].
    #[error(
        "path {index}: delay_s = {value} is outside 0 to {max} s; are the units seconds?",
        max = MAX_DELAY_S
    )]
    Delay {
        /// Position of the path in the slice.
        index: usize,
        /// Its delay \[s\].
        value: f64,
    },
    /// The link has more paths than the labeler takes.
    #[error("{count} paths in one link: at most {max} are taken; drop the weakest")]
    TooMany {
        /// The number given.
        count: usize,
        /// [`Labeler::max_paths`](crate::Labeler::max_paths).
        max: usize,
    },
    /// A point of evaluation, not a path, is NaN or infinite.
    #[error("{field} = {value} is not finite")]
    Point {
        /// Name of the argument.
        field: &'static str,
        /// Its value.
        value: f64,
    },
}

/// Reason to refuse values for normalisation.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NormalizationError {
    /// There is no value; a link without a path has no label and is left out.
    #[error("no values to normalise: leave links without a path out")]
    Empty,
    /// A value is not finite, or too large for a sum.
    #[error("value {index} is {value}: must be finite and within the range of a power in dB")]
    Value {
        /// Its position.
        index: usize,
        /// The value.
        value: f64,
    },
    /// The statistics cannot be divided by.
    #[error(
        "mean {mean}, deviation {std}: the mean must be finite, the deviation finite and positive"
    )]
    Statistics {
        /// Mean.
        mean: f64,
        /// Standard deviation.
        std: f64,
    },
}
