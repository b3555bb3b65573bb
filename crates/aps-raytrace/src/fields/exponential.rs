//! e^x for many numbers at once.

/// e^x for -87 <= x <= 0, relative error below 3e-7; smaller x count as -87, where it is 2e-38. No branches: a loop over it
/// becomes vector instructions, with the same bits on each machine.
#[inline(always)]
pub(super) fn exp_of_negative(x: f32) -> f32 {
    // x = n ln 2 + r, |r| <= ln 2 / 2. The sum with the large number rounds to whole numbers.
    const ROUND: f32 = 12_582_912.0;
    const LN_2_HIGH: f32 = 0.693_359_4;
    const LN_2_LOW: f32 = -2.121_944_4e-4;
    let x = x.max(-87.0);
    let n = x * std::f32::consts::LOG2_E + ROUND;
    let scale = f32::from_bits(n.to_bits().wrapping_add(127) << 23);
    let n = n - ROUND;
    let r = (x - n * LN_2_HIGH) - n * LN_2_LOW;
    // Taylor's series: the first term left out is r^7 / 5040 < 2e-7 at the ends.
    let series = 1.0 / 120.0 + r * (1.0 / 720.0);
    let series = 1.0 / 24.0 + r * series;
    let series = 1.0 / 6.0 + r * series;
    let series = 0.5 + r * series;
    let series = 1.0 + r * series;
    (1.0 + r * series) * scale
}

#[cfg(test)]
mod tests {
    use super::exp_of_negative;

    #[test]
    fn stays_near_the_exponential_on_all_of_its_range() {
        let mut worst = 0.0_f64;
        for i in 0..=870_000 {
            let x = -1e-4 * i as f32;
            let exact = f64::from(x).exp();
            worst = worst.max((f64::from(exp_of_negative(x)) / exact - 1.0).abs());
        }
        assert!(worst < 3e-7, "{worst:e}");
        assert_eq!(exp_of_negative(0.0), 1.0);
        assert_eq!(exp_of_negative(-1e9), exp_of_negative(-87.0));
        assert_eq!(exp_of_negative(f32::NEG_INFINITY), exp_of_negative(-87.0));
    }
}
