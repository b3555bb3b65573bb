//! Errors of the input; each message names the fault and its remedy.

use std::fmt;

/// Largest magnitude a value of a spectrum may have, so that no sum of squares and no
/// product of two of them overflows. No `f32` exceeds it.
pub const MAX_MAGNITUDE: f64 = 1e70;

/// Shape of a row-major array of spectra, displayed the way NumPy writes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Number of rows: spectra.
    pub samples: usize,
    /// Number of columns: azimuth bins of a spectrum.
    pub bins: usize,
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {})", self.samples, self.bins)
    }
}

/// Role of a spectrum in a sample: truth or prediction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Side {
    /// The spectrum scored against.
    Truth,
    /// The spectrum being scored.
    Prediction,
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Side::Truth => "truth",
            Side::Prediction => "prediction",
        })
    }
}

/// A value no metric is defined on: NaN, infinite, or beyond [`MAX_MAGNITUDE`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Defect {
    /// Spectrum that holds the value. The truth is searched first.
    pub side: Side,
    /// First bin of the spectrum with such a value.
    pub bin: usize,
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "bin {} of the {} is NaN, infinite or beyond {:e}",
            self.bin, self.side, MAX_MAGNITUDE
        )
    }
}

/// Input this crate cannot score.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Truth and prediction differ in shape.
    #[error(
        "truth has shape {truth} but prediction has shape {prediction}: \
         both must hold the same samples in the same order, on the same angle grid"
    )]
    ShapeMismatch {
        /// Shape of the truth.
        truth: Shape,
        /// Shape of the prediction.
        prediction: Shape,
    },
    /// A spectrum without bins.
    #[error("a spectrum needs at least one bin, got arrays with 0 columns")]
    NoBins,
    /// The length of a flat array is no multiple of the number of bins.
    #[error(
        "{values} values do not divide into spectra of {bins} bins: the last row is incomplete"
    )]
    IncompleteRow {
        /// Length of the flat array.
        values: usize,
        /// Bins asked for.
        bins: usize,
    },
    /// A chunk has another number of bins than the chunks before it.
    #[error("this chunk has {found} bins a spectrum, the samples before it had {expected}")]
    BinsChanged {
        /// Bins of the samples so far.
        expected: usize,
        /// Bins of this chunk.
        found: usize,
    },
    /// The number of map ids differs from the number of samples.
    #[error("{ids} map ids for {samples} samples: give one a sample, or none at all")]
    MapIds {
        /// Number of map ids.
        ids: usize,
        /// Number of samples.
        samples: usize,
    },
    /// The number of values differs from the number of samples.
    #[error("{values} values for {samples} samples: give one a sample, in the same order")]
    ValuesOfSamples {
        /// Number of values.
        values: usize,
        /// Number of samples.
        samples: usize,
    },
    /// A data range that is not a positive, finite number.
    #[error("the data range must be positive and finite, got {0}")]
    DataRange(f64),
    /// The truth or the prediction of a sample holds a value no metric is defined on.
    #[error("{0}: leave the sample out or repair what produced it")]
    Unscorable(Defect),
    /// A slice holds a value that is NaN, infinite, or beyond a limit.
    #[error("value {index} is NaN, infinite or beyond {limit:e}")]
    NotFinite {
        /// Index of the value in the slice.
        index: usize,
        /// The largest magnitude: [`MAX_MAGNITUDE`] of a spectrum, more of a metric.
        limit: f64,
    },
    /// A level of confidence that is no share.
    #[error("the level must be a share from 0 to 1, got {0}")]
    Level(f64),
    /// More replicates than there is memory for.
    #[error("{replicates} replicates of {clusters} clusters take too much memory: draw fewer")]
    Replicates {
        /// Replicates asked for.
        replicates: usize,
        /// Transmitters of all maps.
        clusters: usize,
    },
}
