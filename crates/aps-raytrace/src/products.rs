//! The four products of a diffraction coefficient, side by side.
//!
//! A product cot(delta / 2n) F(2 k L sin^2(delta / 2)) is sign(delta) g(delta) R K(w), with g = cot(delta / 2n) sin(delta / 2), R = sqrt(2 k L)
//! and w = R |sin(delta / 2)|: finite at the boundary, where delta is 0. A coefficient needs four of them, and their derivatives
//! by delta where slopes are taken along; one instruction takes all four.

use std::f64::consts::{PI, TAU};

use multiversion::multiversion;
use num_complex::Complex64;

use crate::transition::{each_with_slopes, horner};

/// One value for each boundary: of the shadow, past the other face, of the reflections on the 0-face and on the n-face.
pub(crate) type Four = [f64; 4];

/// Angle from a boundary \[rad\] below which the derivatives of g are taken from their series: the closed form subtracts large numbers.
const SMALL_RAD: f64 = 1e-3;

/// Coefficients of sin(pi f)/(pi f) in f^2 on |f| <= 1/2; Chebyshev fit in 60 digits, error 2.1e-19 before the rounding of the
/// coefficients. `aps-label` has the same ones.
const SINC: [f64; 9] = [
    1.0,
    -1.6449340668482264,
    0.8117424252833393,
    -0.19075182412149616,
    0.02614784780555096,
    -0.0023460808954639607,
    0.0001484278414189103,
    -6.972099660851199e-06,
    2.4502943624559793e-07,
];

/// Values of the products at angles from the boundaries. `kl` is wavenumber times distance parameter.
pub(crate) fn values(deltas: &Four, n: f64, kl: f64) -> [Complex64; 4] {
    let mut parts = [[[0.0; 4]; 2]; 1];
    fill_values(deltas, n, kl, &mut parts);
    let [[re, im]] = parts;
    std::array::from_fn(|l| Complex64::new(re[l], im[l]))
}

/// Values of the products with their first and second derivatives by delta.
pub(crate) fn with_slopes(deltas: &Four, n: f64, kl: f64) -> [[Complex64; 3]; 4] {
    let mut parts = [[[0.0; 4]; 2]; 3];
    fill_with_slopes(deltas, n, kl, &mut parts);
    std::array::from_fn(|l| parts.map(|[re, im]| Complex64::new(re[l], im[l])))
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn fill_values(deltas: &Four, n: f64, kl: f64, out: &mut [[Four; 2]; 1]) {
    products(deltas, n, kl, out);
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn fill_with_slopes(deltas: &Four, n: f64, kl: f64, out: &mut [[Four; 2]; 3]) {
    products(deltas, n, kl, out);
}

/// Real and imaginary parts of the products and of as many derivatives as there is room for.
#[inline(always)]
fn products<const ORDERS: usize>(deltas: &Four, n: f64, kl: f64, out: &mut [[Four; 2]; ORDERS]) {
    let root = (2.0 * kl).sqrt();
    let curvature = n / 12.0 + 1.0 / (6.0 * n);
    let mut g = [[0.0; 4]; 3];
    let mut w = [[0.0; 4]; 3];
    for l in 0..4 {
        let a = deltas[l].abs();
        // In half turns, at most 1/2 and 1.
        let (whole, half) = (a / (TAU * n), a / TAU);
        let (sin, cos) = (sin_pi(whole), sin_pi(0.5 - whole));
        let half_cos = sin_pi(0.5 - half);
        let half_sin = sin_pi(if half > 0.5 { 1.0 - half } else { half });
        g[0][l] = cos * (half_sin / sin);
        let square = 1.0 / (sin * sin * (2.0 * n));
        let first = 0.5 * (cos / sin) * half_cos - square * half_sin;
        let second = (g[0][l] / n - half_cos) * square - 0.25 * g[0][l];
        let is_small = a < SMALL_RAD;
        g[1][l] = if is_small { -curvature * a } else { first };
        g[2][l] = if is_small { -curvature } else { second };
        w[0][l] = root * half_sin;
        w[1][l] = 0.5 * root * half_cos;
        w[2][l] = -0.25 * root * half_sin;
    }
    let k = each_with_slopes(&w[0]);
    for part in 0..2 {
        for l in 0..4 {
            let k = [
                k[0][part][l],
                k[1][part][l] * w[1][l],
                k[2][part][l] * (w[1][l] * w[1][l]) + k[1][part][l] * w[2][l],
            ];
            let [g, g_1, g_2] = g.map(|g| g[l]);
            let sign = root.copysign(deltas[l]);
            let derivatives = [
                k[0] * g * sign,
                (k[0] * g_1 + k[1] * g) * root,
                (k[0] * g_2 + k[1] * (2.0 * g_1) + k[2] * g) * sign,
            ];
            for (out, value) in out.iter_mut().zip(derivatives) {
                out[part][l] = value;
            }
        }
    }
}

/// sin(pi f) for |f| <= 1/2, with a relative error of a few 1e-16.
#[inline(always)]
fn sin_pi(f: f64) -> f64 {
    PI * (f * horner(&SINC, f * f))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_agrees_with_the_library() {
        for i in -10_000..=10_000 {
            let f = 5e-5 * f64::from(i);
            let expected = (PI * f).sin();
            assert!(
                (sin_pi(f) - expected).abs() <= 6e-16 * expected.abs(),
                "{f}"
            );
        }
    }

    fn at(shadow: f64) -> Four {
        [shadow, -shadow, f64::MIN_POSITIVE, -f64::MIN_POSITIVE]
    }

    #[test]
    fn values_are_the_same_bits_with_slopes() {
        for n in [1.001, 1.5, 2.0] {
            for (i, kl) in (0..400).zip([1e-3, 1.0, 18.0, 1e3, 1e6].into_iter().cycle()) {
                let deltas = at(n * PI * f64::from(i + 1) / 400.0);
                let values = values(&deltas, n, kl);
                assert!(values.iter().all(|value| value.is_finite()));
                let with_slopes = with_slopes(&deltas, n, kl);
                assert_eq!(values, with_slopes.map(|[value, ..]| value));
                assert!(with_slopes.iter().flatten().all(|value| value.is_finite()));
                // On a boundary a product is n sqrt(pi kl 2) e^{j pi / 4}, on the side that its sign tells.
                let limit = Complex64::from_polar(n * (PI * 2.0 * kl).sqrt(), PI / 4.0);
                assert!((values[2] - limit).norm() < 1e-9 * limit.norm());
                assert_eq!(values[3], -values[2]);
            }
        }
    }

    /// Argument at which the series of g is replaced by its closed form.
    #[test]
    fn derivatives_do_not_jump_where_their_series_ends() {
        for n in [1.1, 1.5, 2.0] {
            let [below, above] =
                [SMALL_RAD.next_down(), SMALL_RAD].map(|d| with_slopes(&at(d), n, 50.0)[0]);
            for (below, above) in below.into_iter().zip(above) {
                assert!(
                    (below - above).norm() < 1e-5 * above.norm(),
                    "{below} {above}"
                );
            }
        }
    }
}
