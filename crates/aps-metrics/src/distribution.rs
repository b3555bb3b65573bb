//! Exact statistics of a column of numbers.

use crate::pointwise::{maximum, minimum};

/// Statistics of one metric over samples. Every number is finite.
///
/// Quantiles interpolate linearly between order statistics (NumPy's default, type 7 of Hyndman
/// and Fan, The American Statistician 50(4), 1996); `std` divides by the number of samples, as
/// `numpy.std` does.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Distribution {
    /// Number of samples, at least 1.
    pub count: usize,
    /// Arithmetic mean.
    pub mean: f64,
    /// Population standard deviation.
    pub std: f64,
    /// Smallest value.
    pub min: f64,
    /// 5 % quantile.
    pub q05: f64,
    /// 25 % quantile.
    pub q25: f64,
    /// 50 % quantile.
    pub median: f64,
    /// 75 % quantile.
    pub q75: f64,
    /// 95 % quantile.
    pub q95: f64,
    /// Largest value.
    pub max: f64,
}

impl Distribution {
    /// Statistics of finite values; `None` if there are none. O(n).
    ///
    /// Sums run in the given order and carry their rounding error along, so the result depends
    /// on the values and their order alone.
    pub fn of(mut values: Vec<f64>) -> Option<Self> {
        let count = values.len();
        if count == 0 {
            return None;
        }
        let mean = compensated_sum(values.iter().copied()) / count as f64;
        let (min, max) = (minimum(&values), maximum(&values));
        // The squares of the largest NMSE there can be, 4e152, have no sum in f64.
        let unit = if (max - min) > 1e100 { max - min } else { 1.0 };
        let squares = compensated_sum(values.iter().map(|v| ((v - mean) / unit).powi(2)));
        let [q05, q25, median, q75, q95] = quantiles(&mut values, [0.05, 0.25, 0.5, 0.75, 0.95]);
        let std = (squares / count as f64).sqrt() * unit;
        Some(Self {
            count,
            mean,
            std,
            min,
            q05,
            q25,
            median,
            q75,
            q95,
            max,
        })
    }
}

/// Quantiles at ascending shares in \[0, 1\] of at least one value; reorders the values.
pub(crate) fn quantiles<const N: usize>(values: &mut [f64], shares: [f64; N]) -> [f64; N] {
    let last = values.len() - 1;
    // Below this index the order statistics asked for so far are in their places.
    let mut placed = 0;
    shares.map(|share| {
        let position = share * last as f64;
        let below = (position as usize).min(last);
        let above = (below + 1).min(last);
        for index in [below, above] {
            if index >= placed {
                values[placed..].select_nth_unstable_by(index - placed, f64::total_cmp);
                placed = index + 1;
            }
        }
        let (a, b, t) = (values[below], values[above], position - below as f64);
        // Exact at both ends and within [a, b] between them.
        if t < 0.5 {
            a + (b - a) * t
        } else {
            b - (b - a) * (1.0 - t)
        }
    })
}

/// Sum with a running correction of the rounding error (Neumaier, ZAMM 54, 1974).
pub(crate) fn compensated_sum(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, correction) = values.fold((0.0_f64, 0.0), |(sum, correction), value| {
        let next = sum + value;
        let lost = if sum.abs() >= value.abs() {
            (sum - next) + value
        } else {
            (value - next) + sum
        };
        (next, correction + lost)
    });
    sum + correction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_values_have_no_distribution() {
        assert_eq!(Distribution::of(Vec::new()), None);
    }

    #[test]
    fn one_value_is_every_quantile() {
        let one = Distribution::of(vec![3.5]).expect("one value");
        assert_eq!(
            (one.mean, one.std, one.q05, one.median, one.max),
            (3.5, 0.0, 3.5, 3.5, 3.5)
        );
    }

    #[test]
    fn quantiles_interpolate() {
        // numpy.quantile([1, 2, 4, 8], [0.05, 0.25, 0.5, 0.75, 0.95])
        let d = Distribution::of(vec![8.0, 1.0, 4.0, 2.0]).expect("four values");
        let found = [d.q05, d.q25, d.median, d.q75, d.q95];
        for (found, expected) in found.into_iter().zip([1.15, 1.75, 3.0, 5.0, 7.4]) {
            assert!((found - expected).abs() < 1e-14, "{found} != {expected}");
        }
    }

    #[test]
    fn sum_keeps_small_values_beside_large_ones() {
        let values = [1e16, 1.0, -1e16, 1.0];
        assert_eq!(compensated_sum(values.into_iter()), 2.0);
    }
}
