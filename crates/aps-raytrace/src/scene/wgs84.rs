//! The ellipsoid of WGS 84.

/// Semi-major axis \[m\].
pub(super) const EQUATOR_M: f64 = 6_378_137.0;

/// Inverse flattening 1 / f.
pub(super) const INVERSE_FLATTENING: f64 = 298.257_223_563;
