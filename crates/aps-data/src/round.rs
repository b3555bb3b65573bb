//! Double to half precision in one rounding, on every CPU alike.

use half::f16;
use half::slice::HalfFloatSliceExt;

/// The nearest half-precision number, ties to even.
pub(crate) fn to_f16(value: f64) -> f16 {
    f16::from_f32(to_odd(value))
}

/// The nearest half-precision numbers of some values, many at once; `odd` is memory that is used again.
pub(crate) fn to_f16s(values: &[f64], odd: &mut Vec<f32>, out: &mut [f16]) {
    odd.clear();
    odd.extend(values.iter().map(|&value| to_odd(value)));
    out.convert_from_f32_slice(odd);
}

/// A single-precision number that rounds to the half-precision number that is nearest to a value.
///
/// Going through single precision rounds twice; a single with its last bit set where it is inexact ("round to odd")
/// keeps what the second rounding needs to know. Source: S. Boldo and G. Melquiond, Emulation of FMA and correctly
/// rounded sums, IEEE Trans. Computers 57, 2008, theorem 1.
#[inline(always)]
fn to_odd(value: f64) -> f32 {
    let near = value as f32;
    let error = value - f64::from(near);
    let bits = near.to_bits();
    // Without branches, so that one instruction takes several values. A value that is not finite has no error, or none that is a
    // number.
    let is_inexact = (error != 0.0) & (error.abs() < f64::INFINITY);
    let is_outwards = (error > 0.0) == (near.is_sign_positive());
    let other = if is_outwards {
        bits.wrapping_add(1)
    } else {
        bits.wrapping_sub(1)
    };
    let moves = is_inexact & (bits & 1 == 0);
    f32::from_bits(if moves { other } else { bits })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_the_range_are_kept() {
        assert_eq!(to_f16(65_504.0), f16::MAX);
        assert_eq!(to_f16(1e300), f16::INFINITY);
        assert_eq!(to_f16(-1e300), f16::NEG_INFINITY);
        assert!(to_f16(f64::NAN).is_nan());
        assert_eq!(to_f16(0.0).to_bits(), 0);
    }

    /// The definition, without a thought for speed: of the half-precision numbers around a value the nearer, or the even one.
    fn nearest(value: f64) -> f16 {
        let mut best = f16::ZERO;
        for bits in 0..0x7c00_u16 {
            let [near, far] =
                [best, f16::from_bits(bits)].map(|x| (x.to_f64() - value.abs()).abs());
            if far < near || (far == near && bits & 1 == 0) {
                best = f16::from_bits(bits);
            }
        }
        if value.is_sign_negative() {
            -best
        } else {
            best
        }
    }

    #[test]
    fn many_at_once_are_the_nearest_each() {
        let mut values = vec![
            0.0, -0.0, 1e-9, -3e-8, 2.98e-8, 65_519.9, -6.1e-5, 1e-46, 0.1, -40.0,
        ];
        // Ties, and what lies just beside them.
        for tie in [
            2049.0,
            2051.0,
            -1.000_488_281_25,
            5.960_464_477_539_063e-8 * 1.5,
        ] {
            values.extend([
                tie,
                tie * (1.0 + 1e-15),
                tie * (1.0 - 1e-15),
                tie * (1.0 + 1e-9),
            ]);
        }
        values.extend((0..50).map(|i| -f64::from(i * i) * 0.017));
        let mut found = vec![f16::NAN; values.len()];
        to_f16s(&values, &mut vec![7.0], &mut found);
        for (found, &value) in found.iter().zip(&values) {
            let expected = nearest(value);
            assert_eq!(
                found.to_bits(),
                expected.to_bits(),
                "{value}: {found} for {expected}"
            );
            assert_eq!(to_f16(value).to_bits(), expected.to_bits());
        }
    }
}
