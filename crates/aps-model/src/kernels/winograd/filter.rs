//! The one-dimensional transforms of minimal filtering F(M, 3): M outputs of a filter with three taps from N = M + 2
//! products (Lavin and Gray, CVPR 2016). With a signal d, taps g and outputs y, `y = A' ((G g) * (B' d))`.
//!
//! The matrices are those of polynomial interpolation at N - 1 points and at infinity (Toom and Cook).

/// F(M, 3) and its adjoint.
pub(super) trait Filter<const M: usize, const N: usize> {
    /// B' d
    fn input(d: [f32; N]) -> [f32; N];
    /// G g
    fn kernel(g: [f32; 3]) -> [f32; N];
    /// A' m
    fn output(m: [f32; N]) -> [f32; M];
    /// A y, the backward pass of [`output`](Filter::output)
    fn output_gradient(y: [f32; M]) -> [f32; N];
    /// G' u, the backward pass of [`kernel`](Filter::kernel)
    fn kernel_gradient(u: [f32; N]) -> [f32; 3];
}

/// F(2, 3) with the points 0, 1, -1: all factors are 1 and 1/2, so that rounding hardly grows.
pub(super) struct Two;

impl Filter<2, 4> for Two {
    #[inline(always)]
    fn input([d0, d1, d2, d3]: [f32; 4]) -> [f32; 4] {
        [d0 - d2, d1 + d2, d2 - d1, d1 - d3]
    }

    #[inline(always)]
    fn kernel([g0, g1, g2]: [f32; 3]) -> [f32; 4] {
        let (sum, middle) = (0.5 * (g0 + g2), 0.5 * g1);
        [g0, sum + middle, sum - middle, g2]
    }

    #[inline(always)]
    fn output([m0, m1, m2, m3]: [f32; 4]) -> [f32; 2] {
        [m0 + m1 + m2, m1 - m2 - m3]
    }

    #[inline(always)]
    fn output_gradient([y0, y1]: [f32; 2]) -> [f32; 4] {
        [y0, y0 + y1, y0 - y1, -y1]
    }

    #[inline(always)]
    fn kernel_gradient([u0, u1, u2, u3]: [f32; 4]) -> [f32; 3] {
        let sum = 0.5 * (u1 + u2);
        [u0 + sum, 0.5 * (u1 - u2), sum + u3]
    }
}

/// F(4, 3) with the points 0, ±√½, ±√2: their powers stay nearest to 1, which keeps the error of f32 at about four times
/// that of [`Two`] (the usual 0, ±1, ±2 have fifteen times).
pub(super) struct Four;

/// The points a and b; b = 2 a, a² = 1/2 and b² = 2.
const A: f32 = std::f32::consts::FRAC_1_SQRT_2;
const B: f32 = std::f32::consts::SQRT_2;

impl Filter<4, 6> for Four {
    #[inline(always)]
    fn input([d0, d1, d2, d3, d4, d5]: [f32; 6]) -> [f32; 6] {
        let (even_a, odd_a) = (d4 - 2.0 * d2, A * d3 - B * d1);
        let (even_b, odd_b) = (d4 - 0.5 * d2, B * d3 - A * d1);
        [
            d0 - 2.5 * d2 + d4,
            even_a + odd_a,
            even_a - odd_a,
            even_b + odd_b,
            even_b - odd_b,
            d1 - 2.5 * d3 + d5,
        ]
    }

    #[inline(always)]
    fn kernel([g0, g1, g2]: [f32; 3]) -> [f32; 6] {
        let (even_a, odd_a) = (-2.0 / 3.0 * g0 - 1.0 / 3.0 * g2, -2.0 / 3.0 * A * g1);
        let (even_b, odd_b) = (1.0 / 6.0 * g0 + 1.0 / 3.0 * g2, 1.0 / 6.0 * B * g1);
        [
            g0,
            even_a + odd_a,
            even_a - odd_a,
            even_b + odd_b,
            even_b - odd_b,
            g2,
        ]
    }

    #[inline(always)]
    fn output([m0, m1, m2, m3, m4, m5]: [f32; 6]) -> [f32; 4] {
        let (even_a, odd_a) = (m1 + m2, A * (m1 - m2));
        let (even_b, odd_b) = (m3 + m4, B * (m3 - m4));
        [
            m0 + even_a + even_b,
            odd_a + odd_b,
            0.5 * even_a + 2.0 * even_b,
            0.5 * odd_a + 2.0 * odd_b + m5,
        ]
    }

    #[inline(always)]
    fn output_gradient([y0, y1, y2, y3]: [f32; 4]) -> [f32; 6] {
        let (even_a, odd_a) = (y0 + 0.5 * y2, A * (y1 + 0.5 * y3));
        let (even_b, odd_b) = (y0 + 2.0 * y2, B * (y1 + 2.0 * y3));
        [
            y0,
            even_a + odd_a,
            even_a - odd_a,
            even_b + odd_b,
            even_b - odd_b,
            y3,
        ]
    }

    #[inline(always)]
    fn kernel_gradient([u0, u1, u2, u3, u4, u5]: [f32; 6]) -> [f32; 3] {
        let (even_a, odd_a) = (u1 + u2, u1 - u2);
        let (even_b, odd_b) = (u3 + u4, u3 - u4);
        [
            u0 - 2.0 / 3.0 * even_a + 1.0 / 6.0 * even_b,
            -2.0 / 3.0 * A * odd_a + 1.0 / 6.0 * B * odd_b,
            -1.0 / 3.0 * even_a + 1.0 / 3.0 * even_b + u5,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Filtering through the transforms against the sum it is, and every adjoint against its forward.
    fn check<F: Filter<M, N>, const M: usize, const N: usize>(tolerance: f32) {
        let d: [f32; N] = std::array::from_fn(|i| (i as f32 * 1.7 + 0.3).sin());
        let g = [0.4, -0.9, 0.7];
        let (dd, gg) = (F::input(d), F::kernel(g));
        let y = F::output(std::array::from_fn(|i| dd[i] * gg[i]));
        for (i, y) in y.into_iter().enumerate() {
            let expected = d[i] * g[0] + d[i + 1] * g[1] + d[i + 2] * g[2];
            assert!((y - expected).abs() < tolerance, "{y}, {expected}");
        }
        let m: [f32; N] = std::array::from_fn(|i| (i as f32 * 2.3 - 0.8).cos());
        let z: [f32; M] = std::array::from_fn(|i| (i as f32 * 0.9 + 1.1).cos());
        let dot = |a: &[f32], b: &[f32]| -> f32 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let there = dot(&F::output(m), &z);
        assert!((there - dot(&m, &F::output_gradient(z))).abs() < tolerance);
        let there = dot(&F::kernel(g), &m);
        assert!((there - dot(&g, &F::kernel_gradient(m))).abs() < tolerance);
    }

    #[test]
    fn two_outputs() {
        check::<Two, 2, 4>(1e-6);
    }

    #[test]
    fn four_outputs() {
        check::<Four, 4, 6>(4e-6);
    }
}
