//! Upper bounds of diffraction coefficients, for many pairs of rays at once.
//!
//! D is -e^{-j pi/4} / (2 n sqrt(2 pi k)) times a sum of four products Gamma cot(delta / 2n) F(x) (see [`crate::utd`]), delta the
//! angle from a boundary in [-n pi, n pi], x = 2 k L sin^2(delta / 2). The bound rests on three facts.
//!
//! **F is near 1.** F(x) = integral from 0 to infinity of e^{-t} (1 - j t / x)^{-1/2} dt (Kouyoumjian and Pathak's integral with
//! z = e^{j pi/4} sqrt(x) in sqrt(pi) e^{z^2} erfc(z) = integral of e^{-t} (z^2 + t)^{-1/2} dt). For w(u) = (1 - j u)^{-1/2}, u >= 0:
//! |w| <= 1, |w| <= u^{-1/2}, and |w'| <= 1/2, so |1 - w| <= u / 2. Integrated: |F| <= 1, |F| <= sqrt(pi x), |1 - F| <= 1 / (2 x).
//!
//! **x is large unless the cotangent is.** With c = cos(delta / 2n): |sin(delta / 2)| >= |sin(delta / 2n)| (alpha + (n - alpha) |c|),
//! alpha = sin(n pi / 2). For sin(n t) / sin(t) is, as a function of z = (1 - cos t) / 2, n 2F1(1 - n, 1 + n; 3/2; z), whose
//! coefficients beyond the first are all negative or zero for 1 <= n <= 2. It is concave in cos t, so above its chord from
//! t = pi/2 (alpha) to t = 0 (n). And it is at most n.
//!
//! **Cotangents do not mind the wrap** by multiples of 2 n pi, so their angles are sums and differences of the rays' own.
//!
//! Products far from their boundary (x >= [`FAR`]) are summed as complex numbers with F = 1, and |Gamma cot| / (2 x) is added for
//! what F differs; of those next to it the magnitude is added, at most |Gamma| |c| n sqrt(2 pi k L). Reflections and shadow cancel
//! as they do in D: away from the boundaries the bound is D itself.
//!
//! **With slopes** ([`crate::slope`]) two corners are D_1 D_2 + mu D_1' D_2', at most the product of the lengths of the vectors
//! (D, sqrt|mu| D') by Cauchy and Schwarz; a corner between two others is a matrix, at most the root of the sum of its four squares. So
//! each corner has its own bound still, sqrt(D^2 + (|mu_1| + |mu_2|) D'^2 + |mu_1 mu_2| D''^2). A product is g(delta) R K(w) up to its
//! sign, g = cot(delta / 2n) sin(delta / 2), R = sqrt(2 k L), w = R |sin(delta / 2)|. K = 2 j integral from 0 to infinity of e^{-j t^2 - 2 j w t} dt,
//! turned into the complex plane, gives |K| <= sqrt(pi), |K'| <= 2, |K''| <= 2 sqrt(pi); and K' = 2 j (F - 1), K'' = 4 j x F' / w with the
//! bounds of F above and |x F'| <= 1 / (2 x), from its integral, give |K| <= 1 / w, |K'| <= 1 / w^2, |K''| <= 2 / w^3. With t = delta / 2n,
//! g = cos t S(t), S = sin(n t) / sin t: |S| <= n, and by concavity |dS / d cos t| <= n, the largest |d^2 S / (d cos t)^2| is (n^2 - 1) alpha at
//! t = pi/2. So |g| <= n |c|, |g'| <= |sin t| (1 + |c|) / 2, |g''| <= (9/4 n + (n^2 - 1) alpha) / (4 n^2). The slopes' bounds sum magnitudes.

use std::f64::consts::PI;
use std::ops::Range;

use multiversion::multiversion;
use num_complex::Complex64;

use crate::ray::Ray;

/// Least x of a product that counts as far from its boundary: both bounds of it are about equal here.
const FAR: f64 = 0.7;

/// Error bound of the sines and cosines of the angles between rays: twice their largest rounding error.
const ANGLE_ERROR: f64 = 4e-15;

/// Error of the transition function as it is computed, relative; [`crate::transition`] promises half of it.
const TRANSITION_ERROR: f64 = 2e-9;

/// Least sine, for which smaller ones are taken, so that products of two are numbers.
const SMALLEST: f64 = 1e-150;

/// Factor for the errors of slopes as they are computed; [`crate::transition`] promises a tenth of it.
const SLOPE_MARGIN: f64 = 1.0 + 1e-5;

/// Factor for the rounding of the steps that follow.
const MARGIN: f64 = 1.0 + 1e-9;

/// Makes the numbers of a direction, and the same in columns.
macro_rules! direction {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// The numbers of a ray that bounds are made of.
        #[derive(Debug, Clone, Copy, Default)]
        pub(crate) struct Direction {
            $($(#[$doc])* $name: f64,)*
        }

        /// Count of numbers in a direction.
        const COLUMNS: usize = [$(stringify!($name)),*].len();

        impl Direction {
            fn columns(&self) -> [f64; COLUMNS] {
                [$(self.$name),*]
            }

            #[inline(always)]
            fn at(columns: [&[f64]; COLUMNS], i: usize) -> Self {
                let [$($name),*] = columns;
                Self { $($name: $name[i]),* }
            }
        }
    };
}

direction! {
    /// Cosine of the angle from the 0-face over 2 n; `sin` is the sine of the same angle.
    cos,
    sin,
    from_0,
    from_n,
    length_m,
    /// Reflection coefficients of the faces.
    re_0,
    im_0,
    re_n,
    im_n,
    norm_0,
    norm_n,
    /// Magnitude |mu|; 0 for a ray that takes no slope along.
    slope,
    /// Factor of the value: 0 for a ray of which only the slope goes on, else 1.
    value,
    /// Magnitudes of the slopes of the reflection coefficients, of a ray along the face.
    slope_0,
    slope_n,
}

/// Directions in columns, so that one instruction takes several of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Directions {
    columns: [Vec<f64>; COLUMNS],
    /// True when any of them takes a slope along: a leg of length 0 among others takes none.
    is_sloped: bool,
}

impl Directions {
    pub fn push(&mut self, direction: &Direction) {
        self.is_sloped |= direction.slope > 0.0;
        for (column, value) in self.columns.iter_mut().zip(direction.columns()) {
            column.push(value);
        }
    }

    /// Memory a direction takes.
    pub const BYTES: usize = COLUMNS * size_of::<f64>();
}

/// The numbers of a wedge that bounds are made of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WedgeBound {
    n: f64,
    /// Cosine of pi / 2n; `sin` is the sine of the same angle.
    cos: f64,
    sin: f64,
    /// sin(n pi / 2).
    alpha: f64,
    /// Half of the largest |c| / (alpha + (n - alpha) |c|)^2 for |c| in 0..=1.
    steepest: f64,
    /// Bound of |g''|.
    curvature: f64,
    /// Bounds of the largest (1 + |c|) / S, (1 + |c|) / S^2, 1 / S and |c| / S^3 for |c| in 0..=1, where S = alpha + (n - alpha) |c|.
    most: [f64; 4],
    /// 2 k \[1/m\].
    twice_wavenumber: f64,
    /// 1 / (2 n sqrt(2 pi k)) \[sqrt(m)\].
    factor: f64,
}

impl WedgeBound {
    /// Prepares the bounds at a wedge with the open angle n pi; `factor` stands in front of its D.
    pub fn new(n: f64, wavenumber_per_m: f64, factor: Complex64) -> Self {
        let (sin, cos) = (PI / (2.0 * n)).sin_cos();
        let alpha = (n * PI / 2.0).sin().max(0.0);
        // It grows up to |c| = alpha / (n - alpha).
        let c = (alpha / (n - alpha)).min(1.0);
        let steepest = 0.5 * c.max(ANGLE_ERROR) / (alpha + (n - alpha) * c).powi(2);
        Self {
            n,
            cos,
            sin,
            alpha,
            steepest,
            most: [
                (1.0 / alpha).max(2.0 / n),
                (1.0 / alpha).max(2.0 / n) * (1.0 / alpha).max(1.0 / n),
                (1.0 / alpha).max(1.0 / n),
                {
                    let c = (0.5 * alpha / (n - alpha)).min(1.0);
                    c.max(ANGLE_ERROR) / (alpha + (n - alpha) * c).powi(3)
                },
            ],
            curvature: (2.25 * n + (n * n - 1.0) * alpha) / (4.0 * n * n),
            twice_wavenumber: 2.0 * wavenumber_per_m,
            factor: factor.norm() * MARGIN,
        }
    }

    /// Makes the numbers of a ray at this wedge; `slopes` are the magnitudes of the slopes of the faces' reflection coefficients for it.
    pub fn direction(&self, ray: &Ray, [slope_0, slope_n]: [f64; 2]) -> Direction {
        let (sin, cos) = (ray.from_0 / (2.0 * self.n)).sin_cos();
        Direction {
            cos,
            sin,
            from_0: ray.from_0,
            from_n: ray.from_n,
            length_m: ray.length_m,
            re_0: ray.gamma_0.re,
            im_0: ray.gamma_0.im,
            re_n: ray.gamma_n.re,
            im_n: ray.gamma_n.im,
            norm_0: ray.gamma_0.norm(),
            norm_n: ray.gamma_n.norm(),
            slope: ray.slope.abs(),
            value: if ray.is_slope_alone() { 0.0 } else { 1.0 },
            slope_0,
            slope_n,
        }
    }

    /// Bounds between one ray and each of others, in place of what `out` holds.
    pub fn of_each(
        &self,
        p: &Direction,
        others: &Directions,
        range: Range<usize>,
        out: &mut Vec<f64>,
    ) {
        out.clear();
        out.resize(range.len(), 0.0);
        let columns = others
            .columns
            .each_ref()
            .map(|column| &column[range.clone()]);
        match (p.slope > 0.0, others.is_sloped) {
            (false, false) => bound_each(self, p, columns, out),
            (true, true) => bound_each_with_slopes(self, p, columns, out),
            _ => bound_each_with_slope(self, p, columns, out),
        }
    }

    /// The bound with slopes for one pair of rays; without `BOTH`, one of them takes none along.
    #[inline(always)]
    fn with_slopes<const BOTH: bool>(&self, p: &Direction, q: &Direction) -> f64 {
        let value = self.of(p, q);
        let (cc, ss) = (p.cos * q.cos, p.sin * q.sin);
        let (sc, cs) = (p.sin * q.cos, p.cos * q.sin);
        let twice_kl =
            self.twice_wavenumber * (p.length_m * q.length_m / (p.length_m + q.length_m));
        let [far, near] = self.slopes([cc + ss, sc - cs], twice_kl);
        let [at_n, at_0] = self.slopes([cc - ss, sc + cs], twice_kl);
        let pick = |first: bool, a: f64, b: f64| if first { a } else { b };
        let gamma_0 = pick(p.from_0 <= q.from_0, p.norm_0, q.norm_0);
        let gamma_n = pick(p.from_n <= q.from_n, p.norm_n, q.norm_n);
        let by_angle = |i: usize| far[i] + near[i] + gamma_n * at_n[i] + gamma_0 * at_0[i];
        let varying = |ray: &Direction, i: usize| ray.slope_0 * at_0[i] + ray.slope_n * at_n[i];
        let value = value * p.value * q.value;
        let by_p = (by_angle(1) + varying(p, 0)) * q.value;
        let by_q = (by_angle(1) + varying(q, 0)) * p.value;
        let mut slopes = p.slope * (by_p * by_p) + q.slope * (by_q * by_q);
        if BOTH {
            let by_both = by_angle(2) + varying(p, 1) + varying(q, 1);
            slopes += p.slope * q.slope * (by_both * by_both);
        }
        let factor = self.factor * SLOPE_MARGIN;
        (value * value + factor * factor * slopes).sqrt() * MARGIN
    }

    /// Bounds of the magnitudes of the two products whose cotangents are of an angle (over 2 n) plus and minus pi, and of their first and
    /// second derivatives by it.
    #[inline(always)]
    fn slopes(&self, [cos, sin]: [f64; 2], twice_kl: f64) -> [[f64; 3]; 2] {
        let (cc, ss) = (cos * self.cos, sin * self.sin);
        let (sc, cs) = (sin * self.cos, cos * self.sin);
        let (root, turned) = (twice_kl.sqrt(), [[cc - ss, sc + cs], [cc + ss, sc - cs]]);
        let low = turned.map(|[_, sin]| (sin.abs() - ANGLE_ERROR).max(SMALLEST));
        let inverse = 1.0 / (low[0] * low[1]);
        let inverse = [inverse * low[1], inverse * low[0]];
        // Next to a boundary and far from it: the lesser of the two bounds holds.
        let near = PI.sqrt() * root;
        let [most_1, most_2, most_3, most_4] = self.most;
        std::array::from_fn(|i| {
            let ([cos, sin], inverse) = (turned[i], inverse[i]);
            let (abs_sin, c) = (sin.abs() + ANGLE_ERROR, cos.abs() + ANGLE_ERROR);
            let square = inverse * inverse;
            // Half of g R^2 K', and half of R g' K.
            let of_k_1 = self.n * (c * twice_kl).min(self.steepest * square);
            let value = self.n * (c * near).min(c * most_3 * inverse);
            let first = (abs_sin * near).min(0.5 * most_1) + of_k_1;
            let of_k = self.curvature * near.min(most_3 * inverse);
            let of_g_1 = (2.0 * abs_sin * twice_kl).min(0.5 * most_2 * inverse);
            let of_k_2 = 0.5 * self.n * (c * near * twice_kl).min(most_4 * square * inverse);
            [value, first, of_k + of_g_1 + 0.5 * of_k_1 + of_k_2]
        })
    }

    /// The bound of |D| for one pair of rays, without slopes.
    #[inline(always)]
    pub fn of(&self, p: &Direction, q: &Direction) -> f64 {
        let (cc, ss) = (p.cos * q.cos, p.sin * q.sin);
        let (sc, cs) = (p.sin * q.cos, p.cos * q.sin);
        let (difference, sum) = ([cc + ss, sc - cs], [cc - ss, sc + cs]);
        let twice_kl =
            self.twice_wavenumber * (p.length_m * q.length_m / (p.length_m + q.length_m));
        let cap = self.n * (PI * twice_kl).sqrt();
        let [[far, far_rest], [near, near_rest]] = self.terms(difference, twice_kl, cap);
        let [[at_n, rest_n], [at_0, rest_0]] = self.terms(sum, twice_kl, cap);
        let pick = |first: bool, a: f64, b: f64| if first { a } else { b };
        let (p_0, p_n) = (p.from_0 <= q.from_0, p.from_n <= q.from_n);
        let re = far - near + (pick(p_n, p.re_n, q.re_n) * at_n - pick(p_0, p.re_0, q.re_0) * at_0);
        let im = pick(p_n, p.im_n, q.im_n) * at_n - pick(p_0, p.im_0, q.im_0) * at_0;
        let rest = far_rest
            + near_rest
            + pick(p_0, p.norm_0, q.norm_0) * rest_0
            + pick(p_n, p.norm_n, q.norm_n) * rest_n;
        ((re * re + im * im).sqrt() + rest) * self.factor
    }

    /// The two products, but for Gamma, whose cotangents are of an angle (over 2 n) plus and minus pi: each as its cotangent where it
    /// is far from its boundary, 0 next to it; and what is to be added for the rest.
    #[inline(always)]
    fn terms(&self, [cos, sin]: [f64; 2], twice_kl: f64, cap: f64) -> [[f64; 2]; 2] {
        let (cc, ss) = (cos * self.cos, sin * self.sin);
        let (sc, cs) = (sin * self.cos, cos * self.sin);
        let turned = [[cc - ss, sc + cs], [cc + ss, sc - cs]];
        let abs_sin = turned.map(|[_, sin]| (sin.abs() - ANGLE_ERROR).max(SMALLEST));
        let steepest = self.steepest / twice_kl;
        // Divisions are the main cost: one serves both.
        let inverse = 1.0 / (abs_sin[0] * abs_sin[1]);
        let inverse = [inverse * abs_sin[1], inverse * abs_sin[0]];
        std::array::from_fn(|i| {
            let [cos, sin] = turned[i];
            let (abs_cos, inverse) = (cos.abs() + ANGLE_ERROR, inverse[i]);
            let half = abs_sin[i] * (self.alpha + (self.n - self.alpha) * cos.abs());
            let is_far = twice_kl * (half * half) >= FAR;
            let cotangent = abs_cos * inverse;
            // |cot| / 2 x, with the largest |c| / (alpha + (n - alpha) |c|)^2 there is.
            let cubed = inverse * (inverse * inverse) * steepest;
            let far_rest = cubed.min(cotangent * (0.5 / FAR))
                + 4.0 * ANGLE_ERROR * (inverse * inverse)
                + cotangent * TRANSITION_ERROR;
            let near_rest = cotangent.min(abs_cos * cap) * (1.0 + TRANSITION_ERROR);
            [
                if is_far {
                    cos * inverse.copysign(sin)
                } else {
                    0.0
                },
                if is_far { far_rest } else { near_rest },
            ]
        })
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn bound_each(wedge: &WedgeBound, p: &Direction, columns: [&[f64]; COLUMNS], out: &mut [f64]) {
    each(columns, out, |q| wedge.of(p, q));
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn bound_each_with_slopes(
    wedge: &WedgeBound,
    p: &Direction,
    columns: [&[f64]; COLUMNS],
    out: &mut [f64],
) {
    each(columns, out, |q| wedge.with_slopes::<true>(p, q));
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn bound_each_with_slope(
    wedge: &WedgeBound,
    p: &Direction,
    columns: [&[f64]; COLUMNS],
    out: &mut [f64],
) {
    each(columns, out, |q| wedge.with_slopes::<false>(p, q));
}

#[inline(always)]
fn each(columns: [&[f64]; COLUMNS], out: &mut [f64], bound: impl Fn(&Direction) -> f64) {
    let count = out.len();
    let columns = columns.map(|column| &column[..count]);
    for (i, out) in out.iter_mut().enumerate() {
        *out = bound(&Direction::at(columns, i));
    }
}

/// A bound in single precision, rounded upwards, below the normal range too.
pub(crate) fn rounded_up(bound: f64) -> f32 {
    (bound * (1.0 + 3e-7) + f64::from(f32::from_bits(1))) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Material;
    use crate::scene::{Footprint, Scene};
    use crate::wedge::Wedge;
    use glam::DVec2;
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    /// The corner at the origin of a triangle with the interior angle given, and its open angle.
    fn corner(interior_rad: f64, material: Material, frequency_hz: f64) -> (Wedge, f64) {
        let tip = DVec2::from_angle(interior_rad) * 40.0;
        let house = Footprint::new([DVec2::ZERO, DVec2::new(40.0, 0.0), tip]);
        let scene = Scene::new(&[house], None).unwrap();
        let reflectors: Vec<_> = scene
            .walls()
            .iter()
            .map(|_| material.at(frequency_hz))
            .collect();
        let wavenumber = TAU * frequency_hz / crate::SPEED_OF_LIGHT_M_PER_S;
        let mut wedges = scene.wedges(&reflectors, wavenumber).into_iter();
        let wedge = wedges.find(|w| w.point == DVec2::ZERO).unwrap();
        (wedge, TAU - interior_rad)
    }

    fn material() -> impl Strategy<Value = Material> {
        let dielectric = (1.0..20.0, 0.0..10.0).prop_map(|(eps, sigma)| Material::Dielectric {
            relative_permittivity: eps,
            conductivity_s_per_m: sigma,
        });
        prop_oneof![
            Just(Material::Concrete),
            Just(Material::PerfectConductor),
            dielectric
        ]
    }

    /// A ray: part of the open angle, and how far away its end is.
    fn ray() -> impl Strategy<Value = (f64, f64)> {
        let part = prop_oneof![0.0..=1.0, Just(0.0), Just(1.0), Just(0.5)];
        (part, (-2.0..4.0).prop_map(|e| 10.0_f64.powf(e)))
    }

    /// mu of a leg, or none.
    fn slope() -> impl Strategy<Value = f64> {
        prop_oneof![Just(0.0), (-9.0..1.0).prop_map(|e| 10.0_f64.powf(e))]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

        #[test]
        fn bound_is_never_below_the_coefficient(
            interior in 0.005..3.1,
            material in material(),
            frequency in prop_oneof![Just(3.5e9), (6.0..13.0).prop_map(|e| 10.0_f64.powf(e))],
            (p, q) in (ray(), ray()),
            slopes in (slope(), slope()),
            // Near one of the boundaries, or anywhere.
            boundary in 0..5,
            off in (-16.0..0.0).prop_map(|e| 10.0_f64.powf(e)),
            beyond in any::<bool>(),
        ) {
            let (wedge, open) = corner(interior, material, frequency);
            let phi = p.0 * open;
            let other = match boundary {
                0 => phi + PI,
                1 => phi - PI,
                2 => PI - phi,
                3 => 2.0 * open - PI - phi,
                _ => q.0 * open,
            };
            let other = (if beyond { other + off } else { other - off }).clamp(0.0, open);
            // Angles count clockwise from the wall that starts here: the tip's, or the one along x.
            let along = wedge.ray(DVec2::new(1.0, 0.0)).from_0;
            let place = |phi: f64, length: f64| {
                let turned = if along == 0.0 { -phi } else { interior + phi };
                DVec2::from_angle(turned) * length
            };
            let (mut a, mut b) = (wedge.ray(place(phi, p.1)), wedge.ray(place(other, q.1)));
            let exact = wedge.coefficient(&a, &b).norm();
            let directions = [wedge.direction(&a), wedge.direction(&b)];
            let bound = wedge.bound.of(&directions[0], &directions[1]);
            prop_assert!(bound >= exact, "{bound:e} < {exact:e}");
            // Many at once, in columns.
            let mut columns = Directions::default();
            (0..11).for_each(|_| columns.push(&directions[1]));
            let mut bounds = Vec::new();
            wedge.bound.of_each(&directions[0], &columns, 0..11, &mut bounds);
            prop_assert!(bounds.iter().all(|b| b.to_bits() == bound.to_bits()));
            // With slopes.
            (a.slope, b.slope) = slopes;
            let matrix = wedge.matrix(&a, &b);
            let [by_p, by_q, by_both] =
                [matrix.by_first, matrix.by_second, matrix.by_both].map(|slope| slope.norm_sqr());
            let mu = [a.slope, b.slope].map(f64::abs);
            let squares = matrix.value.norm_sqr() + mu[0] * by_p + mu[1] * by_q + mu[0] * mu[1] * by_both;
            let mut columns = Directions::default();
            columns.push(&wedge.direction(&b));
            wedge.bound.of_each(&wedge.direction(&a), &columns, 0..1, &mut bounds);
            prop_assert!(bounds[0] >= squares.sqrt(), "{:e} < {:e}", bounds[0], squares.sqrt());
        }
    }

    #[test]
    fn far_from_the_boundaries_the_bound_is_the_coefficient() {
        let (wedge, _) = corner(PI / 2.0, Material::Concrete, 3.5e9);
        let at = |degrees: f64| {
            let place = DVec2::from_angle(-degrees.to_radians()) * 50.0;
            wedge.ray(place)
        };
        let (a, b) = (at(20.0), at(240.0));
        let [p, q] = [&a, &b].map(|ray| wedge.direction(ray));
        let exact = wedge.coefficient(&a, &b).norm();
        let bound = wedge.bound.of(&p, &q);
        assert!(bound < 1.02 * exact, "{bound:e}, {exact:e}");
    }

    /// Corners that touch are legs of length 0, without slope, beside others that have one.
    #[test]
    fn bounds_of_others_hold_beside_a_leg_without_slope() {
        let (wedge, open) = corner(PI / 2.0, Material::PerfectConductor, 3.5e9);
        let terminal = wedge.ray(DVec2::from_angle(-0.4 * open) * 30.0);
        // Along the wall only the slope goes on.
        let mut along = wedge.ray(DVec2::new(20.0, 0.0));
        along.slope = 1e-3;
        let mut touching = along;
        touching.slope = 0.0;
        let exact =
            |ray: &Ray| (ray.slope * wedge.matrix(&terminal, ray).by_second.norm_sqr()).sqrt();
        let mut columns = Directions::default();
        for ray in [&touching, &along] {
            columns.push(&wedge.direction(ray));
        }
        let mut bounds = Vec::new();
        let p = wedge.direction(&terminal);
        wedge.bound.of_each(&p, &columns, 0..2, &mut bounds);
        assert!(
            exact(&along) > 0.0 && bounds[1] >= exact(&along),
            "{bounds:?}"
        );
    }

    /// Along a wall only the slope goes on, so that a loose bound of it would keep all such paths. Towards either face the slope vanishes, and
    /// its bound does not: there it is larger by up to thirty times.
    #[test]
    fn bound_of_slopes_is_near_them() {
        let (wedge, open) = corner(PI / 2.0, Material::PerfectConductor, 3.5e9);
        let mut worst = 1.0_f64;
        for i in 7..14 {
            let phi = open * f64::from(i) / 20.0;
            let mut along = wedge.ray(DVec2::new(20.0, 0.0));
            along.slope = 1e-3;
            let other = wedge.ray(DVec2::from_angle(-phi) * 30.0);
            let matrix = wedge.matrix(&along, &other);
            let exact = (along.slope * matrix.by_first.norm_sqr()).sqrt();
            let bound = wedge
                .bound
                .with_slopes::<false>(&wedge.direction(&along), &wedge.direction(&other));
            worst = worst.max(bound / exact);
        }
        eprintln!("the bound along a wall is at most {worst:.2} times the slope");
        assert!(worst < 4.0, "{worst}");
    }
}
