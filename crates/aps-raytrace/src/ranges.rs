//! Ranges of settings, as checks and messages name them.

/// Carriers \[Hz\]: from long wave to X-rays.
pub(crate) const FREQUENCY_HZ: std::ops::RangeInclusive<f64> = 1.0..=1e18;

/// Largest relative permittivity: far beyond any material; reflection coefficients are finite up to here.
pub(crate) const MAX_PERMITTIVITY: f64 = 1e9;

/// Largest conductivity \[S/m\]; silver has 6e7.
pub(crate) const MAX_CONDUCTIVITY_S_PER_M: f64 = 1e12;
