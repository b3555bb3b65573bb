//! Polynomials of degree 7 on \[-1, 1\]: interpolation, and a bound of the maximum.

use crate::product::{LANES, Lanes};

/// The zeros of the Chebyshev polynomial T_8: cos((2 j + 1) pi / 16).
///
/// The polynomial that agrees there with a function g is off by at most max |g^(8)| / (8! 2^7).
pub(crate) const NODES: Lanes = [
    -0.980_785_280_403_230_4,
    -0.831_469_612_302_545_2,
    -0.555_570_233_019_602_2,
    -0.195_090_322_016_128_27,
    0.195_090_322_016_128_27,
    0.555_570_233_019_602_2,
    0.831_469_612_302_545_2,
    0.980_785_280_403_230_4,
];

/// Coefficients of the polynomial that is 1 at one node and 0 at the others, a row a node.
const LAGRANGE: [Lanes; LANES] = {
    let mut rows = [[0.0; LANES]; LANES];
    let mut j = 0;
    while j < LANES {
        rows[j][0] = 1.0;
        let mut i = 0;
        while i < LANES {
            if i != j {
                // Times (x - x_i) / (x_j - x_i).
                let scale = 1.0 / (NODES[j] - NODES[i]);
                let mut n = LANES - 1;
                while n > 0 {
                    rows[j][n] = scale * (rows[j][n - 1] - NODES[i] * rows[j][n]);
                    n -= 1;
                }
                rows[j][0] *= -scale * NODES[i];
            }
            i += 1;
        }
        j += 1;
    }
    rows
};

/// Steps towards the top: each cubes the distance, as long as the top is no flatter than a parabola.
const STEPS: usize = 2;

/// Coefficients `[coefficient][lane]`, the constant term first, of the polynomials with these values at
/// the [`NODES`], `[node][lane]`.
#[inline(always)]
pub(crate) fn interpolate<const N: usize>(values: &[[f64; N]; LANES]) -> [[f64; N]; LANES] {
    const HALF: usize = LANES / 2;
    // Opposite nodes: their sums make the even terms, their differences the odd ones.
    let (mut even, mut odd) = ([[0.0; N]; HALF], [[0.0; N]; HALF]);
    for j in 0..HALF {
        let (right, left) = (&values[HALF + j], &values[HALF - 1 - j]);
        for l in 0..N {
            even[j][l] = right[l] + left[l];
            odd[j][l] = right[l] - left[l];
        }
    }
    let sum = |parts: &[[f64; N]; HALF], n: usize| {
        let mut sum = [0.0; N];
        for l in 0..N {
            for j in 0..HALF {
                sum[l] += LAGRANGE[HALF + j][n] * parts[j][l];
            }
        }
        sum
    };
    [
        sum(&even, 0),
        sum(&odd, 1),
        sum(&even, 2),
        sum(&odd, 3),
        sum(&even, 4),
        sum(&odd, 5),
        sum(&even, 6),
        sum(&odd, 7),
    ]
}

/// Searches eight polynomials, `[coefficient][lane]`, and leaves their expansions at a point near the
/// top, the value first. Returns that point, and upper bounds of the polynomials on \[-1, 1\].
///
/// At each step the polynomial is expanded anew and Halley's method applied to its derivative. With
/// the final expansion c_n, the values at a distance t <= T on one side are at most
/// c_0 + t (c_1 + t B), where B is c_2 and, times powers of T, the later terms that are positive.
#[inline(always)]
pub(crate) fn top<const N: usize>(c: &mut [[f64; N]; LANES]) -> ([f64; N], [f64; N]) {
    let mut x = [0.0; N];
    let mut step = [0.0; N];
    for _ in 0..STEPS {
        for l in 0..N {
            let (c1, c2, c3) = (c[1][l], c[2][l], c[3][l]);
            let halley = 4.0 * (c2 * c2) - 3.0 * (c1 * c3);
            let concave = c2 < 0.0;
            // Without a top the higher end.
            let above = if concave { -2.0 * (c1 * c2) } else { c1 };
            let below = if concave { halley } else { f64::MIN_POSITIVE };
            let newton = concave & (halley <= 0.0);
            let above = if newton { -c1 } else { above };
            let below = if newton { 2.0 * c2 } else { below };
            let next = x[l] + above / below;
            let next = if next < 1.0 { next } else { 1.0 };
            let next = if next > -1.0 { next } else { -1.0 };
            step[l] = next - x[l];
            x[l] = next;
        }
        for first in 0..LANES - 1 {
            for n in (first..LANES - 1).rev() {
                for l in 0..N {
                    c[n][l] += step[l] * c[n + 1][l];
                }
            }
        }
    }
    let mut upper = [0.0; N];
    for l in 0..N {
        let left = excess(c, l, -1.0, 1.0 + x[l]);
        let right = excess(c, l, 1.0, 1.0 - x[l]);
        upper[l] = c[0][l] + if left > right { left } else { right };
    }
    (x, upper)
}

/// Upper bound of a polynomial less its value at 0, as far as `reach` on one side.
#[inline(always)]
fn excess<const N: usize>(c: &[[f64; N]; LANES], lane: usize, sign: f64, reach: f64) -> f64 {
    let positive = |x: f64| if x > 0.0 { x } else { 0.0 };
    let mut bend = positive(sign * c[7][lane]);
    bend = positive(c[6][lane]) + reach * bend;
    bend = positive(sign * c[5][lane]) + reach * bend;
    bend = positive(c[4][lane]) + reach * bend;
    bend = positive(sign * c[3][lane]) + reach * bend;
    reach * positive(sign * c[1][lane] + reach * positive(c[2][lane] + reach * bend))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value(c: &Lanes, x: f64) -> f64 {
        c.iter().rev().fold(0.0, |sum, c| sum * x + c)
    }

    proptest! {
        #[test]
        fn polynomials_are_their_own_interpolation(c in prop::array::uniform8(-1.0..1.0_f64)) {
            let found = interpolate(&NODES.map(|x| [value(&c, x)]));
            for ([found], c) in found.iter().zip(&c) {
                prop_assert!((found - c).abs() < 1e-12, "{} {}", found, c);
            }
        }

        #[test]
        fn no_value_is_above_the_bound(c in prop::array::uniform8(-1.0..1.0_f64), flat in -12.0..0.0_f64) {
            // From all terms alike to a parabola.
            let c: Lanes = std::array::from_fn(|n| if n > 2 { c[n] * 10_f64.powf(flat) } else { c[n] });
            let mut expansion = c.map(|c| [c; LANES]);
            let (x, upper) = top(&mut expansion);
            prop_assert!((value(&c, x[0]) - expansion[0][0]).abs() < 1e-12);
            for i in -1000..=1000 {
                let here = value(&c, f64::from(i) * 1e-3);
                prop_assert!(here <= upper[0] + 1e-12, "{} > {}", here, upper[0]);
            }
            if flat < -9.0 {
                let found = expansion[0][0];
                prop_assert!(upper[0] - found < 1e-6 || c[2] > 0.0, "{} {}", upper[0], found);
            }
        }
    }
}
