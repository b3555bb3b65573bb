//! The exponential function and the normal distribution, written so that a compiler makes vectors of them.

/// e^x within 1.5 units of the last place where the result is a normal number; 0 and infinity beyond what f32 holds.
///
/// x = n ln 2 + r with |r| <= ln 2 / 2; the series of e^r is cut behind r^7 / 7!, below 6e-9 of the result.
#[inline(always)]
pub(super) fn exp(x: f32) -> f32 {
    // Adding and subtracting it rounds to a whole number.
    const ROUND: f32 = 1.5 * (1 << 23) as f32;
    // ln 2 = HIGH + LOW; n * HIGH is exact for |n| < 2^10.
    const HIGH: f32 = 0.693_359_4;
    const LOW: f32 = -2.121_944_4e-4;
    // Beyond, the result is 0 or infinite whatever x; NaN stays.
    let x = x.clamp(-150.0, 130.0);
    let shifted = x * std::f32::consts::LOG2_E + ROUND;
    let n = shifted - ROUND;
    let r = (x - n * HIGH) - n * LOW;
    let series = [
        1.0 / 5040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ];
    let mut sum = 0.0;
    for factor in series {
        sum = sum * r + factor;
    }
    // In two steps, as 2^n itself may lie outside of f32.
    let n = shifted.to_bits().wrapping_sub(ROUND.to_bits()) as i32;
    let half = n >> 1;
    sum * power_of_two(half) * power_of_two(n - half)
}

/// 2^n for -126 <= n <= 127.
#[inline(always)]
fn power_of_two(n: i32) -> f32 {
    f32::from_bits(((n + 127) << 23) as u32)
}

/// The density of the standard normal distribution at `x`, and its integral from below up to `x` within 4e-7 of itself
/// times 1 + x² / 4.
///
/// The part beyond |x| is density times Mills' ratio, which is t P(t) with t = 1 / (1 + 0.35 |x|) and P of degree 8 within
/// 3.2e-8 (fitted by `tests/golden/mills.py`).
#[inline(always)]
pub(super) fn normal(x: f32) -> (f32, f32) {
    const P: [f32; 9] = [
        -0.073_088_34,
        0.361_033_7,
        -0.641_296_8,
        0.399_359_17,
        -0.058_187_35,
        0.264_581_95,
        0.300_347_18,
        0.350_585_88,
        0.349_978_72,
    ];
    // 1 / sqrt(2 pi)
    const AT_0: f32 = 0.398_942_3;
    let density = AT_0 * exp(-0.5 * x * x);
    let t = 1.0 / (1.0 + 0.35 * x.abs());
    let mut p = 0.0;
    for factor in P {
        p = p * t + factor;
    }
    let beyond = density * p * t;
    (density, if x > 0.0 { 1.0 - beyond } else { beyond })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_to_the_last_place() {
        let mut worst: f64 = 0.0;
        for i in -87_000..88_500 {
            let x = i as f32 * 1e-3;
            let exact = f64::from(x).exp();
            let ulp = f64::from(exact as f32).log2().floor().exp2() * f64::from(f32::EPSILON);
            worst = worst.max((f64::from(exp(x)) - exact).abs() / ulp);
        }
        assert!(worst < 1.5, "{worst} units of the last place");
    }

    #[test]
    fn exponential_at_the_ends() {
        assert_eq!(exp(0.0), 1.0);
        assert_eq!(exp(f32::NEG_INFINITY), 0.0);
        assert_eq!(exp(-1e30), 0.0);
        assert_eq!(exp(f32::INFINITY), f32::INFINITY);
        assert_eq!(exp(89.0), f32::INFINITY);
        assert!(exp(f32::NAN).is_nan());
        // Denormal results lose digits, no more.
        let tiny = f64::from(exp(-100.0));
        assert!((tiny / (-100f64).exp() - 1.0).abs() < 0.02, "{tiny}");
    }

    #[test]
    fn normal_distribution() {
        for i in -12_500..=12_500 {
            let x = i as f32 * 1e-3;
            let (density, below) = normal(x);
            let x = f64::from(x);
            let exact = libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2) / 2.0;
            let bound = 4e-7 * (1.0 + x * x / 4.0);
            let error = (f64::from(below) / exact - 1.0).abs();
            assert!(error < bound, "at {x}: off by {error:e}");
            let exact = (-x * x / 2.0).exp() / (2.0 * std::f64::consts::PI).sqrt();
            let error = (f64::from(density) / exact - 1.0).abs();
            assert!(error < bound, "density at {x}: off by {error:e}");
        }
        assert_eq!(normal(f32::INFINITY), (0.0, 1.0));
        assert_eq!(normal(f32::NEG_INFINITY), (0.0, 0.0));
        assert!(normal(f32::NAN).1.is_nan());
    }
}
