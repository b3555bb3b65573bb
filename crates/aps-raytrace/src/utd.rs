//! Diffraction at a straight wedge, as plain numbers: the uniform theory of diffraction (UTD).
//!
//! A wedge has two plane faces, the 0-face and the n-face; between them lies an open angle of
//! n pi, 1 < n < 2 at a convex corner. Rays from the edge are given by their angle phi from the
//! 0-face, 0 to n pi. The electric field is parallel to the edge (vertical polarisation at a
//! vertical corner, "soft") and the rays are perpendicular to it. The time factor is
//! e^{+j omega t}.
//!
//! ```
//! use std::f64::consts::PI;
//! use aps_raytrace::{Complex64, utd};
//! // A right-angled corner (n = 1.5) of perfect conductor at 3.5 GHz; source 10 m away at 45
//! // degrees from one wall, receiver 20 m away, 10 degrees behind the shadow boundary.
//! let (n, k, s1, s2) = (1.5, 73.36, 10.0, 20.0);
//! let (phi_1, phi_2) = (0.25 * PI, 1.25 * PI + 10_f64.to_radians());
//! let gamma = Complex64::new(-1.0, 0.0);
//! let d = utd::diffraction_coefficient(n, k, utd::distance_m(s1, s2), phi_1, phi_2, gamma, gamma);
//! // Of the field that would be there without the building, 8.5 % is left (-21 dB).
//! let left = d.norm() * ((s1 + s2) / (s1 * s2)).sqrt();
//! assert!((left - 0.085).abs() < 0.001);
//! ```
//!
//! # Sources
//!
//! The coefficient is that of Kouyoumjian and Pathak (Proc. IEEE 62, 1974, pp. 1448-1461, eqs. 25
//! to 29). For walls of finite conductivity the two reflection terms are multiplied by the faces'
//! reflection coefficients, after Luebbers (IEEE Trans. AP-32, 1984, pp. 70-76). Luebbers takes
//! the angle at the 0-face from the incident ray and that at the n-face from the diffracted ray,
//! so that exchanging the two changes the result. [`incidence_cosines`] takes them from the ray
//! nearer to each face, which is his choice where the source is nearer to the 0-face, and
//! symmetric. For a perfect conductor nothing of this matters.

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use num_complex::Complex64;

use crate::products;

/// The diffraction coefficient D \[sqrt(m)\] of a wedge with an open angle of `n` pi.
///
/// `phi_1` and `phi_2` are the angles of the two rays from the 0-face \[rad\], 0 to n pi, in
/// either order: D is symmetric in them. `distance_m` is the distance parameter L \[m\], see
/// [`distance_m()`]; `gamma_0` and `gamma_n` are the reflection coefficients of the faces, -1 for
/// a perfect conductor, see [`incidence_cosines`] for others.
///
/// The diffracted field is the field incident at the edge times
/// D sqrt(s' / (s (s' + s))) e^{-j k s} for a point source at s' from the edge, and times
/// D e^{-j k s} / sqrt(s) for a plane wave.
///
/// Finite for all angles. D jumps at shadow and reflection boundaries, by just what the other
/// rays lose there. Exactly on a boundary the direct ray counts as present, and so does the ray
/// reflected on the 0-face; the one reflected on the n-face counts as absent. |D| is at most
/// (2 + |`gamma_0`| + |`gamma_n`|) sqrt(L) / 2.
#[must_use]
pub fn diffraction_coefficient(
    n: f64,
    wavenumber_per_m: f64,
    distance_m: f64,
    phi_1: f64,
    phi_2: f64,
    gamma_0: Complex64,
    gamma_n: Complex64,
) -> Complex64 {
    let boundaries = Boundaries::new(n, phi_1, phi_2);
    let terms = boundaries.terms(n, wavenumber_per_m * distance_m, gamma_0, gamma_n);
    terms * factor(n, wavenumber_per_m)
}

/// The distance parameter L = s' s / (s' + s) \[m\] of rays of two lengths; for a plane wave on
/// one side it is the other length.
#[inline]
#[must_use]
pub fn distance_m(length_1_m: f64, length_2_m: f64) -> f64 {
    length_1_m * length_2_m / (length_1_m + length_2_m)
}

/// Cosines of the angles of incidence at the 0-face and at the n-face: sin(phi) of the ray
/// nearer to the 0-face, and sin(n pi - phi) of the ray nearer to the n-face.
///
/// At a reflection boundary this is the angle of the reflected ray, so that the field is
/// continuous there.
#[inline]
#[must_use]
pub fn incidence_cosines(n: f64, phi_1: f64, phi_2: f64) -> [f64; 2] {
    let (low, high) = (phi_1.min(phi_2), phi_1.max(phi_2));
    [low.sin().abs(), (n * PI - high).sin().abs()]
}

/// Factor of D in front of the brackets: -e^{-j pi/4} / (2 n sqrt(2 pi k)) \[sqrt(m)\].
#[inline]
#[must_use]
pub(crate) fn factor(n: f64, wavenumber_per_m: f64) -> Complex64 {
    let magnitude = 0.5 / (n * (TAU * wavenumber_per_m).sqrt());
    Complex64::new(-FRAC_1_SQRT_2, FRAC_1_SQRT_2) * magnitude
}

/// Angles of a pair of rays from the four directions in which a cotangent of D has its pole
/// \[rad\], each in [-n pi, n pi]. The sign tells the side, and is never lost: no value is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Boundaries {
    /// Angle beyond the shadow boundary: the difference of the angles less pi. Negative: the rays see
    /// each other.
    pub shadow: f64,
    /// Angle beyond the shadow boundary past the other face, likewise. Only a wedge with n = 1 has this boundary, at grazing.
    pub shadow_far: f64,
    /// Angle beyond the reflection on the 0-face: the sum of the angles less pi. Negative: there is
    /// one.
    pub reflection_0: f64,
    /// Angle past the first reflection on the n-face: the sum less (2 n - 1) pi. Positive: there is
    /// one.
    pub reflection_n: f64,
}

impl Boundaries {
    /// Computes the angles from those of two rays alone. On a boundary the direct ray and the reflection on the 0-face
    /// count as present, that on the n-face as absent.
    pub fn new(n: f64, phi_1: f64, phi_2: f64) -> Self {
        let difference = (phi_1 - phi_2).abs();
        let sum = phi_1 + phi_2;
        Self {
            shadow: off_zero(difference - PI),
            shadow_far: off_zero(wrap(difference + PI, n)),
            reflection_0: off_zero(wrap(sum - PI, n)),
            reflection_n: off_zero(wrap(sum + PI, n)),
        }
    }

    /// The bracket of D: four products of cotangent, transition function and reflection
    /// coefficient; `kl` is wavenumber times distance parameter.
    #[inline]
    pub fn terms(&self, n: f64, kl: f64, gamma_0: Complex64, gamma_n: Complex64) -> Complex64 {
        let [near, far, at_0, at_n] = products::values(&self.deltas(), n, kl);
        // In this order a ray along a perfectly conducting 0-face gives exactly 0.
        (far + at_n * gamma_n) - (near + at_0 * gamma_0)
    }

    /// The four angles in the order of [`products`].
    pub fn deltas(&self) -> [f64; 4] {
        [
            self.shadow,
            self.shadow_far,
            self.reflection_0,
            self.reflection_n,
        ]
    }
}

/// Brings an angle into [-n pi, n pi] by multiples of 2 n pi: the nearest integers N+ and N- of
/// the theory.
fn wrap(angle: f64, n: f64) -> f64 {
    let period = TAU * n;
    angle - period * (angle / period).round()
}

/// A boundary itself belongs to its negative side.
fn off_zero(delta: f64) -> f64 {
    if delta == 0.0 {
        -f64::MIN_POSITIVE
    } else {
        delta
    }
}
