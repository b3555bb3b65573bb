//! Limits of settings and paths.

use std::ops::RangeInclusive;

/// The largest delay a path may have \[s\].
pub const MAX_DELAY_S: f64 = 1.0;
/// The most paths a link may have. A label takes memory in proportion to their number, and time for the
/// continuous maximum, where none coincide, in proportion to its square: seconds for all of them.
pub const MAX_PATHS: usize = 16_384;
/// Paths this far below the strongest one of their link \[dB\] are left out: no sum in f64 could show
/// them, and products of such powers would underflow.
pub const NEGLIGIBLE_DB: f64 = 1000.0;
/// Sampling rates for which every promise of accuracy holds \[Hz\].
pub(crate) const SAMPLING_RATE_HZ: RangeInclusive<f64> = 1.0..=1e12;
/// The most elements of an array.
pub(crate) const MAX_ELEMENTS: usize = 4096;
/// The largest spacing or radius of an array \[wavelengths\].
pub(crate) const MAX_WAVELENGTHS: f64 = 1e4;
/// The most points of a delay axis.
pub(crate) const MAX_DELAY_POINTS: usize = 65_536;
