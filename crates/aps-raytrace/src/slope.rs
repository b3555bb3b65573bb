//! Slope diffraction: the diffraction of a wave that varies over the corner, as one that comes from another corner does.
//!
//! Near the second of two corners the wave of the first is not just its value on the line between them but also its slope across it:
//! D_1'/s per metre, the derivative by the angle at the first corner over the length s of the leg. A wave of value 0 and of that slope is
//! the difference of two plane waves a small angle apart, so what it sends on is D_2'/(j k), the derivative by the angle at the
//! second corner. Two corners together are thus D_1 D_2 + mu D_1' D_2' with mu = j / (k s), both derivatives by angles clockwise from
//! the 0-faces: what lies clockwise as seen from one end lies counterclockwise from the other, and every reflection on the way turns
//! that over, mu its sign. In a chain value and slope go from corner to corner, two numbers, and each corner is a
//! matrix of D and its derivatives by one angle, by the other and by both. All of it is symmetric, so reciprocal.
//!
//! **Along a wall** that reflects, from one of its ends to the other, the value is 0, and only the slope goes on. The slope of D_1 is that of the wave and
//! of its reflection together, and so is what D_2' expects: half of mu. With finite conductivity too the value is 0 there, to the
//! order in 1/k that rays have; of Luebbers' heuristic a rest remains, which is left out. Gamma varies with the angle of the ray
//! along the wall, from -1 at first by [`grazing_slope`](crate::material::Reflector::grazing_slope), which is part of the slope; other rays
//! take Gamma as constant, for the waves that a reflector returns from a slope of Gamma are no rays.
//!
//! **Corners closer than 1/k**: mu grows up to 1 and falls with the distance below it, where a series in 1 / (k s) says nothing. What goes over such
//! a wall into the shadow of both corners is lost, as it is in a cascade.
//!
//! **Continuity.** D jumps where a ray appears, its slope does not: D is odd in the angle from a boundary.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::friis::Friis;
use crate::products;
use crate::ray::Ray;
use crate::utd::Boundaries;

/// Diffraction coefficient D \[sqrt(m)\] and its derivatives by the angles of its rays \[sqrt(m) / rad\].
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct DiffractionMatrix {
    pub value: Complex64,
    pub by_first: Complex64,
    pub by_second: Complex64,
    pub by_both: Complex64,
}

/// The slopes of the faces' reflection coefficients \[1/rad\] with the angles of the two rays from the 0-face, for rays along a face; else 0.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GammaSlopes {
    pub gamma_0: [Complex64; 2],
    pub gamma_n: [Complex64; 2],
}

impl Boundaries {
    /// The bracket of D and its derivatives by the angles of two rays from the face that `gamma_0` is of; `kl` is wavenumber times
    /// distance parameter, `first_is_low`: the first ray is nearer to that face.
    pub fn slopes(
        &self,
        n: f64,
        kl: f64,
        gamma_0: Complex64,
        gamma_n: Complex64,
        slopes: &GammaSlopes,
        first_is_low: bool,
    ) -> DiffractionMatrix {
        let [near, far, at_0, at_n] = products::with_slopes(&self.deltas(), n, kl);
        // The difference of the angles falls with the lower of them.
        let [of_first, of_second] = if first_is_low {
            [-1.0, 1.0]
        } else {
            [1.0, -1.0]
        };
        let direct = |i: usize| far[i] - near[i];
        let reflected = |i: usize| at_n[i] * gamma_n - at_0[i] * gamma_0;
        let varying =
            |ray: usize, i: usize| at_n[i] * slopes.gamma_n[ray] - at_0[i] * slopes.gamma_0[ray];
        DiffractionMatrix {
            // In the order of `terms`: a ray along a perfectly conducting 0-face gives exactly 0.
            value: (far[0] + at_n[0] * gamma_n) - (near[0] + at_0[0] * gamma_0),
            by_first: direct(1) * of_first + reflected(1) + varying(0, 0),
            by_second: direct(1) * of_second + reflected(1) + varying(1, 0),
            by_both: reflected(2) - direct(2) + varying(0, 1) + varying(1, 1),
        }
    }
}

impl DiffractionMatrix {
    /// Takes the derivatives by the angles from the other face.
    pub fn turned_over(self) -> Self {
        Self {
            by_first: -self.by_first,
            by_second: -self.by_second,
            ..self
        }
    }

    /// Multiplies all by a factor.
    pub fn scaled(self, factor: Complex64) -> Self {
        Self {
            value: self.value * factor,
            by_first: self.by_first * factor,
            by_second: self.by_second * factor,
            by_both: self.by_both * factor,
        }
    }
}

impl Friis {
    /// mu / j for a leg between corners with its rays at both ends, at most 1: its sign is that of the reflections on it.
    pub fn slope(self, reflections: u32, [leaving, arriving]: [&Ray; 2]) -> f64 {
        let sign = if reflections.is_multiple_of(2) {
            1.0
        } else {
            -1.0
        };
        let is_along_a_wall = leaving.is_along_a_face() && arriving.is_along_a_face();
        let share = if is_along_a_wall { 0.5 } else { 1.0 };
        let distance = TAU * leaving.length_m / self.wavelength_m;
        sign * share * distance.min(distance.recip())
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use proptest::prelude::*;

    use super::*;
    use crate::utd;

    const PERFECT: Complex64 = Complex64::new(-1.0, 0.0);

    fn matrix(n: f64, kl: f64, [p, q]: [f64; 2], gammas: [Complex64; 2]) -> DiffractionMatrix {
        let boundaries = Boundaries::new(n, p, q);
        let slopes = GammaSlopes::default();
        boundaries.slopes(n, kl, gammas[0], gammas[1], &slopes, p <= q)
    }

    proptest! {
        /// Away from the boundaries, where D jumps.
        #[test]
        fn slopes_are_differences_of_the_coefficient(
            n in 1.01..2.0,
            kl in (0.0..4.0).prop_map(|e| 10.0_f64.powf(e)),
            (p, q) in (0.01..0.99, 0.01..0.99),
            (re_0, re_n) in (-1.0..0.0, -1.0..0.0),
        ) {
            let angles = [p * n * PI, q * n * PI];
            let b = Boundaries::new(n, angles[0], angles[1]);
            let off = [b.shadow, b.reflection_0, b.reflection_n].map(f64::abs);
            prop_assume!(off.iter().all(|&b| b > 1e-3) && f64::abs(p - q) > 1e-3);
            let gammas = [Complex64::new(re_0, 0.3), Complex64::new(re_n, -0.1)];
            let at = |dp: f64, dq: f64| {
                let [p, q] = [angles[0] + dp, angles[1] + dq];
                Boundaries::new(n, p, q).terms(n, kl, gammas[0], gammas[1])
            };
            let found = matrix(n, kl, angles, gammas);
            let h = 1e-4 / kl.sqrt();
            let by_first = (at(h, 0.0) - at(-h, 0.0)) / (2.0 * h);
            let by_second = (at(0.0, h) - at(0.0, -h)) / (2.0 * h);
            let by_both = (at(h, h) - at(h, -h) - at(-h, h) + at(-h, -h)) / (4.0 * h * h);
            // In parts of what they are at a boundary: sqrt(kL), kL and its power 3/2.
            prop_assert!((found.value - at(0.0, 0.0)).norm() < 1e-9 * kl.sqrt());
            prop_assert!((found.by_first - by_first).norm() < 1e-5 * kl, "{found:?}, {by_first}");
            prop_assert!((found.by_second - by_second).norm() < 1e-5 * kl, "{found:?}, {by_second}");
            prop_assert!((found.by_both - by_both).norm() < 1e-3 * kl.powf(1.5), "{found:?}, {by_both}");
        }

        #[test]
        fn exchanging_the_rays_exchanges_their_slopes(
            n in 1.01..2.0,
            (p, q) in (0.0..=1.0, 0.0..=1.0),
        ) {
            let gammas = [Complex64::new(-0.7, 0.1), Complex64::new(-0.4, 0.0)];
            let [forth, back] = [[p, q], [q, p]].map(|angles| matrix(n, 100.0, angles.map(|a| a * n * PI), gammas));
            prop_assert!((forth.by_first - back.by_second).norm() < 1e-9);
            prop_assert!((forth.by_second - back.by_first).norm() < 1e-9);
            prop_assert!((forth.by_both - back.by_both).norm() < 1e-9);
        }

        /// No ray has a slope of its own, so nothing makes up for a jump of it.
        #[test]
        fn slopes_do_not_jump_at_boundaries(n in 1.2..2.0, phi in 0.02..0.98, boundary in 0..3) {
            let phi = phi * n * PI;
            let other = match boundary {
                0 => phi + PI,
                1 => PI - phi,
                _ => (2.0 * n - 1.0) * PI - phi,
            };
            prop_assume!(other > 1e-3 && other < n * PI - 1e-3);
            let [before, after] = [-1e-9, 1e-9].map(|d| matrix(n, 500.0, [phi, other + d], [PERFECT; 2]));
            prop_assert!((before.value - after.value).norm() > 1.0);
            prop_assert!((before.by_first - after.by_first).norm() < 1e-4 * before.by_first.norm());
            prop_assert!((before.by_second - after.by_second).norm() < 1e-4 * before.by_second.norm());
        }
    }

    /// Two half planes whose edges lie on the line from source to receiver: of the field 1/4 + arcsin(rho) / 2 pi is left, rho^2 = s_0 s_2 /
    /// ((s_0 + s_1) (s_1 + s_2)), where the distances are many wavelengths (the integral of the error function over a quadrant).
    #[test]
    fn two_half_planes_in_line_are_nearer_with_slopes() {
        for [s_0, s_1, s_2] in [[1e4, 1e4, 1e4], [1e4, 3e4, 2e4], [3e4, 1e4, 3e4]] {
            let rho = f64::sqrt(s_0 * s_2 / ((s_0 + s_1) * (s_1 + s_2)));
            let exact = 0.25 + rho.asin() / TAU;
            // Edges seen head-on: the faces play no part. Lengths in units of 1/k.
            let angles = [FRAC_PI_2, FRAC_PI_2 + PI + 1e-9];
            let at = |lengths: [f64; 2], angles| {
                let distance = utd::distance_m(lengths[0], lengths[1]);
                matrix(2.0, distance, angles, [Complex64::ZERO; 2]).scaled(utd::factor(2.0, 1.0))
            };
            let (first, second) = (at([s_0, s_1], angles), at([s_1, s_2], angles));
            let spread = ((s_0 + s_1 + s_2) / (s_0 * s_1 * s_2)).sqrt();
            let cascade = first.value * second.value * spread;
            let mu = Complex64::new(0.0, 1.0 / s_1);
            let with_slopes = cascade + mu * first.by_second * second.by_first * spread;
            let errors = [cascade, with_slopes].map(|field| 20.0 * (field.norm() / exact).log10());
            eprintln!(
                "{s_0:e}, {s_1:e}, {s_2:e}: cascade {:.2} dB, with slopes {:.2} dB",
                errors[0], errors[1]
            );
            assert!(
                with_slopes.arg().abs() < 0.02 && errors[1].abs() < 4.0,
                "{with_slopes}"
            );
            assert!(errors[1].abs() < errors[0].abs() / 1.8);
        }
    }
}
