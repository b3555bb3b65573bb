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

/// Below this w a Chebyshev series, above it the asymptotic one.
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
///
/// Costs about 20 ns near the shadow boundaries and a few ns away from them.
#[inline]
#[must_use]
pub fn transition_over_root(w: f64) -> Complex64 {
    if w < SPLIT {
        chebyshev(w)
    } else {
        asymptotic(w)
    }
}

/// K(w) and its first two derivatives, with absolute errors below 1e-10, 2e-9 and 3e-8, and relative ones below 1e-9 from w = 6 on.
///
/// K' = 2 j (w K - 1) and K'' = 2 j (K + w K'); where w is large little is left of those differences, so their series are taken.
#[must_use]
pub fn transition_slopes(w: f64) -> [Complex64; 3] {
    if w < SPLIT {
        let value = chebyshev(w);
        let first = Complex64::new(0.0, 2.0) * (value * w - 1.0);
        let second = Complex64::new(0.0, 2.0) * (value + first * w);
        return [value, first, second];
    }
    // F = w K = 1 - u q_1, q_m = 1 - (2 m + 1) u q_{m + 1}, u = 1 / (2 j w^2): so K' = -2 j u q_1, K'' = 2 j u (3 q_2 - q_1) / w.
    let u = Complex64::new(0.0, -0.5 / (w * w));
    let (mut q_1, mut q_2) = (Complex64::ONE, Complex64::ONE);
    for m in (1..=12).rev() {
        q_2 = q_1;
        q_1 = 1.0 - q_1 * u * f64::from(2 * m + 1);
    }
    let twice = Complex64::new(0.0, 2.0) * u;
    [
        (1.0 - u * q_1) / w,
        -twice * q_1,
        twice * (3.0 * q_2 - q_1) / w,
    ]
}

/// F(x) for x >= 0, with an error below 1e-9 relative.
#[must_use]
pub fn transition(x: f64) -> Complex64 {
    let w = x.sqrt();
    transition_over_root(w) * w
}

/// Clenshaw's recurrence.
fn chebyshev(w: f64) -> Complex64 {
    let t = w * (2.0 / SPLIT) - 1.0;
    let (mut re1, mut re2, mut im1, mut im2) = (0.0, 0.0, 0.0, 0.0);
    for &(re, im) in CHEBYSHEV[1..].iter().rev() {
        (re1, re2) = (re + 2.0 * t * re1 - re2, re1);
        (im1, im2) = (im + 2.0 * t * im1 - im2, im1);
    }
    Complex64::new(
        CHEBYSHEV[0].0 + t * re1 - re2,
        CHEBYSHEV[0].1 + t * im1 - im2,
    )
}

/// K(w) = (1 - 1 u + 1 3 u^2 - 1 3 5 u^3 + ...) / w with u = 1 / (2 j w^2); the terms kept
/// leave less than 1e-10 from w = 6 on.
fn asymptotic(w: f64) -> Complex64 {
    // u = -j v: even powers are real, odd ones imaginary.
    let v = 0.5 / (w * w);
    let terms = if w > 40.0 { 3 } else { 12 };
    let mut sum = Complex64::ONE;
    for m in (1..=terms).rev() {
        let factor = f64::from(2 * m - 1) * v;
        sum = Complex64::new(1.0 - factor * sum.im, factor * sum.re);
    }
    sum / w
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
        let gap = (chebyshev(SPLIT) - asymptotic(SPLIT)).norm();
        assert!(gap < 1e-10, "{gap:e}");
    }

    /// Against differences of the function itself.
    #[test]
    fn slopes_are_those_of_the_function() {
        for i in 0..4000 {
            let w = 0.01 * f64::from(i) + 0.02;
            let step = 1e-2_f64.min(0.01 * w);
            let [value, first, second] = transition_slopes(w);
            let [before, after] = [w - step, w + step].map(transition_slopes);
            assert!((value - transition_over_root(w)).norm() < 2e-10, "{w}");
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
