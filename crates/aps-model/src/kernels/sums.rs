//! Sums in double precision, by lanes that a compiler makes vectors of.

/// Partial sums kept side by side.
pub(super) const LANES: usize = 16;

/// The sum of `f` of each value.
#[inline(always)]
pub(super) fn sum_of(values: &[f32], f: impl Fn(f32) -> f32) -> f64 {
    let mut sums = [0.0f64; LANES];
    let (whole, rest) = values.as_chunks::<LANES>();
    for chunk in whole {
        for (sum, &v) in sums.iter_mut().zip(chunk) {
            *sum += f64::from(f(v));
        }
    }
    for (sum, &v) in sums.iter_mut().zip(rest) {
        *sum += f64::from(f(v));
    }
    sums.iter().sum()
}
