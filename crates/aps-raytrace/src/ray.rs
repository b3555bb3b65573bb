//! A ray at a corner, in the angles of its wedge.

use glam::DVec2;
use num_complex::Complex64;

/// Angle from a face \[rad\] below which a ray runs along it.
pub(crate) const ALONG_RAD: f64 = 1e-9;

/// A ray between a wedge and the (unfolded) place it comes from or goes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ray {
    /// Unfolded distance from the corner \[m\].
    pub length_m: f64,
    /// Angle from the 0-face \[rad\], 0..=n pi.
    pub from_0: f64,
    /// Angle from the n-face \[rad\], 0..=n pi: 0 exactly for a ray along it.
    pub from_n: f64,
    /// Position of the place \[m\].
    pub place: DVec2,
    /// Reflection coefficients of the faces for a ray from here.
    pub gamma_0: Complex64,
    pub gamma_n: Complex64,
    /// mu / j of [`crate::slope`] on the leg that the ray is an end of; 0 where slopes are not taken along.
    pub slope: f64,
}

impl Ray {
    /// Returns true when the ray runs along one of the faces, and that one reflects: walls of vacuum do not.
    pub fn is_along_a_face(&self) -> bool {
        let along = |angle: f64, gamma: Complex64| angle < ALONG_RAD && gamma != Complex64::ZERO;
        along(self.from_0, self.gamma_0) || along(self.from_n, self.gamma_n)
    }

    /// Returns true when the ray is the end of a leg along a face of which only the slope goes on.
    pub fn is_slope_alone(&self) -> bool {
        self.slope != 0.0 && self.is_along_a_face()
    }
}
