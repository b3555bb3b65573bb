//! The transition function of the uniform theory of diffraction.
//!
//! F(x) = 2 j sqrt(x) e^{jx} integral from sqrt(x) to infinity of e^{-j t^2} dt (Kouyoumjian and
//! Pathak, Proc. IEEE 62, 1974, eq. 27). What the diffraction coefficient needs is F against a
//! factor that vanishes with sqrt(x), so the function here is K(w) = F(w^2) / w, smooth down to
//! w = 0, where it is sqrt(pi) e^{j pi/4}.
//!
//! ```
//! use aps_raytrace::transition::{transition, transition_over_root};
//!
//! assert_eq!(transition(0.0).norm(), 0.0); // on a boundary
//! assert!((transition(1e4) - 1.0).norm() < 1e-4); // far from it
//! assert!((transition_over_root(0.0).norm() - std::f64::consts::PI.sqrt()).abs() < 1e-9);
//! ```

use num_complex::Complex64;

/// Argument w from which on the asymptotic series is taken, below it the Chebyshev series.
const SPLIT: f64 = 6.0;

/// Chebyshev coefficients of K(3 (1 + t)), t in -1..=1: real and imaginary parts. Made by
/// `tests/golden/transition.py` in 40 digits; the terms left out are below 2e-11.
const CHEBYSHEV: [(f64, f64); 27] = [
    (0.529_481_065_844_535_4, 0.233_538_242_277_261_55),
    (-0.518_883_121_606_270_7, -0.409_630_156_080_42),
    (0.204_136_626_299_500_44, 0.292_369_036_807_142_6),
    (-0.051_536_520_587_036_956, -0.175_522_620_942_608_07),
    (-0.005_672_864_485_904_716, 0.089_588_803_745_343_85),
    (0.017_750_940_592_944_94, -0.038_427_370_348_180_44),
    (-0.014_072_788_278_546_779, 0.013_135_989_408_594_3),
    (0.007_960_405_162_892_1, -0.002_893_724_943_614_583),
    (-0.003_606_446_170_591_434_8, -0.000_242_204_768_516_900_36),
    (0.001_319_606_289_323_602_5, 0.000_711_870_481_651_895_3),
    (-0.000_360_604_276_268_628_35, -0.000_486_661_300_767_874_6),
    (4.498_041_094_269_626e-5, 0.000_234_400_699_534_570_52),
    (2.427_514_343_232_115_6e-5, -8.860_804_043_475_811e-5),
    (-2.313_203_782_946_887_5e-5, 2.571_607_662_336_442_5e-5),
    (1.190_872_910_172_357_4e-5, -4.558_339_125_939_297e-6),
    (-4.577_648_419_161_357e-6, -5.245_901_459_772_078e-7),
    (1.347_864_114_628_380_8e-6, 9.226_725_315_095_992e-7),
    (-2.616_740_353_544_605e-7, -5.047_747_554_045_588e-7),
    (-3.833_111_257_681_505e-9, 1.944_358_338_163_141_4e-7),
    (3.267_288_636_132_341e-8, -5.666_310_637_415_517_5e-8),
    (-1.857_306_406_844_234_4e-8, 1.111_678_841_806_537_5e-8),
    (7.050_097_180_157_335e-9, -1.844_777_491_362_886_9e-10),
    (-1.995_481_420_081_395_7e-9, -1.068_374_849_044_001_3e-9),
    (3.786_172_272_736_856_5e-10, 6.076_736_675_408_761e-10),
    (-6.938_234_299_486_73e-12, -2.232_013_580_831_323_6e-10),
    (-3.287_682_420_379_123e-11, 6.032_998_608_300_952e-11),
    (1.791_392_183_365_916e-11, -1.069_139_953_859_953_6e-11),
];

/// K(w) = F(w^2) / w for w >= 0, with an absolute error below 1e-10.
#[must_use]
pub fn transition_over_root(w: f64) -> Complex64 {
    transition_slopes(w)[0]
}

/// K(w) and its first two derivatives, with absolute errors below 1e-10, 2e-9 and 3e-8, and relative ones below 1e-9 from w = 6 on.
#[must_use]
pub fn transition_slopes(w: f64) -> [Complex64; 3] {
    each_with_slopes(&[w]).map(|[[re], [im]]| Complex64::new(re, im))
}

/// Real and imaginary parts of K and its first two derivatives, for several w.
///
/// K' = 2 j (w K - 1) and K'' = 2 j (K + w K'); where w is large little is left of those differences, so their series are taken: with
/// u = 1 / (2 j w^2) and the double factorials a_m = (2 m + 1)!!, F = w K = 1 - u q, q = sum a_m (-u)^m, K' = -2 j u q and
/// K'' = 2 j u / w sum (2 m + 2) a_m (-u)^m.
#[inline(always)]
pub(crate) fn each_with_slopes<const N: usize>(w: &[f64; N]) -> [[[f64; N]; 2]; 3] {
    let mut k = [[[0.0; N]; 2]; 3];
    for l in 0..N {
        // -u = j v: even powers are real, odd ones imaginary.
        let inverse = 1.0 / w[l];
        let v = 0.5 * (inverse * inverse);
        let square = v * v;
        let [q, rest] = [&SERIES, &SLOPE_SERIES]
            .map(|[even, odd]| [horner(even, square), v * horner(odd, square)]);
        k[0][0][l] = (1.0 - v * q[1]) * inverse;
        k[0][1][l] = v * q[0] * inverse;
        for part in 0..2 {
            k[1][part][l] = -2.0 * v * q[part];
            k[2][part][l] = 2.0 * v * rest[part] * inverse;
        }
    }
    if w.iter().any(|&w| w < SPLIT) {
        let near = w.map(|w| if w < SPLIT { w } else { SPLIT });
        let [re, im] = chebyshev_each(&near);
        for l in 0..N {
            if w[l] < SPLIT {
                let first = [-2.0 * (w[l] * im[l]), 2.0 * (w[l] * re[l] - 1.0)];
                let second = [
                    -2.0 * (im[l] + w[l] * first[1]),
                    2.0 * (re[l] + w[l] * first[0]),
                ];
                for (k, of_l) in k.iter_mut().zip([[re[l], im[l]], first, second]) {
                    (k[0][l], k[1][l]) = (of_l[0], of_l[1]);
                }
            }
        }
    }
    k
}

/// Terms of the series for large w: what they leave from w = 6 on is below 1e-9 of K and of its derivatives.
const TERMS: usize = 14;

/// Coefficients a_m = (2 m + 1)!! of q, those of even m with the sign of j^m, those of odd m with that of j^m / j.
const SERIES: [[f64; TERMS / 2]; 2] = double_factorials(false);

/// Coefficients (2 m + 2) a_m of the series of K'', with the signs of [`SERIES`].
const SLOPE_SERIES: [[f64; TERMS / 2]; 2] = double_factorials(true);

const fn double_factorials(of_slope: bool) -> [[f64; TERMS / 2]; 2] {
    let mut terms = [[0.0; TERMS / 2]; 2];
    let (mut m, mut a) = (0, 1.0);
    while m < TERMS {
        let sign = if m / 2 % 2 == 0 { 1.0 } else { -1.0 };
        let factor = if of_slope { (2 * m + 2) as f64 } else { 1.0 };
        terms[m % 2][m / 2] = sign * factor * a;
        a *= (2 * m + 3) as f64;
        m += 1;
    }
    terms
}

/// Horner's rule; `c[0]` is the constant term.
#[inline(always)]
pub(crate) fn horner<const TERMS: usize>(c: &[f64; TERMS], x: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// F(x) for x >= 0, with an error below 1e-9 relative.
#[must_use]
pub fn transition(x: f64) -> Complex64 {
    let w = x.sqrt();
    transition_over_root(w) * w
}

/// Clenshaw's recurrence: real and imaginary parts.
#[inline(always)]
fn chebyshev_each<const N: usize>(w: &[f64; N]) -> [[f64; N]; 2] {
    let t = w.map(|w| w * (2.0 / SPLIT) - 1.0);
    let twice = t.map(|t| 2.0 * t);
    // The last two sums of each part.
    let mut sums = [[[0.0; N]; 2]; 2];
    for &(re, im) in CHEBYSHEV[1..].iter().rev() {
        for (coefficient, [sum, before]) in [re, im].into_iter().zip(&mut sums) {
            let next = std::array::from_fn(|l| coefficient + (twice[l] * sum[l] - before[l]));
            (*sum, *before) = (next, *sum);
        }
    }
    let [re, im] = sums;
    let (re_0, im_0) = CHEBYSHEV[0];
    [(re_0, re), (im_0, im)].map(|(coefficient, [sum, before])| {
        std::array::from_fn(|l| coefficient + (t[l] * sum[l] - before[l]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// The bounds of the tracer rest on it.
    #[test]
    fn magnitude_never_exceeds_one() {
        for i in 0..200_000 {
            let x = 10.0_f64.powf(f64::from(i) / 10_000.0 - 10.0);
            assert!(transition(x).norm() <= 1.0 + 1e-12, "{x:e}");
        }
    }

    #[test]
    fn both_series_meet_at_the_split() {
        let [below, above] = [SPLIT.next_down(), SPLIT].map(transition_slopes);
        for (i, most) in [1e-10, 2e-9, 3e-8].into_iter().enumerate() {
            let gap = (below[i] - above[i]).norm();
            assert!(gap < most, "{i}: {gap:e}");
        }
    }

    /// The asymptotic series to its least terms, which are below 1e-14 from w = 6 on.
    #[test]
    fn slopes_for_large_w_are_as_near_as_promised() {
        for i in 0..2000 {
            let w = SPLIT * 1.01_f64.powi(i);
            let step = Complex64::new(0.0, 0.5 / (w * w));
            let (mut a, mut q, mut rest) = (Complex64::ONE, Complex64::ZERO, Complex64::ZERO);
            for m in 0..30 {
                q += a;
                rest += a * f64::from(2 * m + 2);
                a *= step * f64::from(2 * m + 3);
            }
            let expected = [
                (1.0 + step * q) / w,
                step * q * Complex64::new(0.0, 2.0),
                step * rest * Complex64::new(0.0, -2.0) / w,
            ];
            for (found, expected) in transition_slopes(w).into_iter().zip(expected) {
                let error = (found - expected).norm() / expected.norm();
                assert!(error < 1e-9, "{w}: {error:e}");
            }
        }
    }

    /// Against differences of the function itself.
    #[test]
    fn slopes_are_those_of_the_function() {
        for i in 0..4000 {
            let w = 0.01 * f64::from(i) + 0.02;
            let step = 1e-2_f64.min(0.01 * w);
            let [_, first, second] = transition_slopes(w);
            let [before, after] = [w - step, w + step].map(transition_slopes);
            let slope = |i: usize| (after[i] - before[i]) / (2.0 * step);
            let size = 1.0 / (1.0 + w).powi(2);
            assert!((slope(0) - first).norm() < 1e-3 * size, "{w}");
            assert!((slope(1) - second).norm() < 1e-3 * size, "{w}");
        }
    }

    /// The bounds of slopes rest on it.
    #[test]
    fn slopes_never_exceed_their_bounds() {
        for i in 0..100_000 {
            let w = 10.0_f64.powf(f64::from(i) / 10_000.0 - 5.0);
            let [_, first, second] = transition_slopes(w).map(|value| value.norm());
            let most = [
                2.0_f64.min(1.0 / (w * w)),
                PI.sqrt().min(1.0 / w.powi(3)) * 2.0,
            ];
            assert!(first <= most[0] * (1.0 + 1e-6), "{w}: {first:e}");
            assert!(second <= most[1] * (1.0 + 1e-5), "{w}: {second:e}");
        }
    }

    #[test]
    fn at_the_boundary_and_far_from_it() {
        let at_zero = Complex64::from_polar(PI.sqrt(), std::f64::consts::FRAC_PI_4);
        assert!((transition_over_root(0.0) - at_zero).norm() < 1e-10);
        assert!((transition(1e12) - 1.0).norm() < 1e-12);
    }
}
