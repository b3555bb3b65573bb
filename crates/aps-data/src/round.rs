//! Double to half precision in one rounding, on every CPU alike.

use half::f16;

/// The nearest half-precision number, ties to even.
///
/// Going through single precision rounds twice; a single with its last bit set where it is inexact ("round to odd")
/// keeps what the second rounding needs to know. Source: S. Boldo and G. Melquiond, Emulation of FMA and correctly
/// rounded sums, IEEE Trans. Computers 57, 2008, theorem 1.
pub(crate) fn to_f16(value: f64) -> f16 {
    let near = value as f32;
    let error = value - f64::from(near);
    let is_even = near.to_bits() & 1 == 0;
    let odd = if error == 0.0 || error.is_nan() || !is_even || !near.is_finite() {
        near
    } else if error > 0.0 {
        near.next_up()
    } else {
        near.next_down()
    };
    f16::from_f32(odd)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_just_beyond_a_tie_is_not_taken_for_one() {
        // 1 + 2^-11 is halfway between 1 and the next half-precision number.
        let tie = 1.0 + f64::exp2(-11.0);
        assert_eq!(to_f16(tie).to_f64(), 1.0);
        assert_eq!(
            to_f16(tie + f64::exp2(-40.0)).to_f64(),
            1.0 + f64::exp2(-10.0)
        );
        assert_eq!(
            to_f16(-tie - f64::exp2(-40.0)).to_f64(),
            -1.0 - f64::exp2(-10.0)
        );
        assert_eq!(to_f16(tie - f64::exp2(-40.0)).to_f64(), 1.0);
    }

    #[test]
    fn ends_of_the_range_are_kept() {
        assert_eq!(to_f16(65_504.0), f16::MAX);
        assert_eq!(to_f16(1e300), f16::INFINITY);
        assert_eq!(to_f16(-1e300), f16::NEG_INFINITY);
        assert!(to_f16(f64::NAN).is_nan());
        assert_eq!(to_f16(0.0).to_bits(), 0);
    }
}
