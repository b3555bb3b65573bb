//! Mean and standard deviation of a whole training split.

use crate::NormalizationError;

/// Mean and population standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeanStd {
    /// Mean.
    pub mean: f64,
    /// Population standard deviation: the sum is divided by the number of values.
    pub std: f64,
}

/// Sums over any number of values, to be filled by many threads or machines and merged.
///
/// Sums are kept in fixed point, in steps of 2^-60. Integer addition has no rounding, so the result
/// is the same bytes for every order of the values, any sharding and after a resume. There is room
/// for 10^12 values, two thousand data sets of 2.55 million labels.
///
/// ```
/// use aps_label::Moments;
///
/// let (mut a, mut b) = (Moments::default(), Moments::default());
/// a.add(&[0.1, 0.2])?;
/// b.add(&[0.3])?;
/// a.merge(&b);
/// assert!((a.mean_std().unwrap().mean - 0.2).abs() < 1e-15);
/// # Ok::<(), aps_label::NormalizationError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Moments {
    count: u64,
    sum: i128,
    squares: i128,
}

/// 2^60.
const STEPS_PER_ONE: f64 = (1_u64 << 60) as f64;

impl Moments {
    /// Largest magnitude of a value.
    pub const LARGEST: f64 = 1e4;

    /// Adds values: all of them, or none if one is refused.
    ///
    /// # Errors
    ///
    /// A value that is not finite or beyond [`LARGEST`](Self::LARGEST), with its index.
    pub fn add(&mut self, values: &[f64]) -> Result<(), NormalizationError> {
        let fits = |x: &f64| x.abs() <= Self::LARGEST;
        if let Some(index) = values.iter().position(|x| !fits(x)) {
            return Err(NormalizationError::Value {
                index,
                value: values[index],
            });
        }
        // Of small values, as powers relative to the largest are, steps fit into a register.
        if values.iter().all(|x| x.abs() <= 2.0) {
            for &x in values {
                self.sum += i128::from((x * STEPS_PER_ONE) as i64);
                self.squares += i128::from((x * x * STEPS_PER_ONE) as i64);
            }
        } else {
            for &x in values {
                self.sum += (x * STEPS_PER_ONE) as i128;
                self.squares += (x * x * STEPS_PER_ONE) as i128;
            }
        }
        self.count += values.len() as u64;
        Ok(())
    }

    /// Adds the values that `other` has seen.
    pub fn merge(&mut self, other: &Self) {
        self.sum += other.sum;
        self.squares += other.squares;
        self.count += other.count;
    }

    /// Number of values seen.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean and standard deviation, `None` before the first value.
    ///
    /// The variance is the mean square minus the squared mean: relative error about
    /// 2e-16 (1 + mean^2 / variance). To this comes what the steps cut off: up to 2^-60 of the mean, and
    /// 2^-60 (1 + 2 |mean|) of the variance.
    pub fn mean_std(&self) -> Option<MeanStd> {
        if self.count == 0 {
            return None;
        }
        let n = self.count as f64;
        let mean = self.sum as f64 / STEPS_PER_ONE / n;
        let square = self.squares as f64 / STEPS_PER_ONE / n;
        Some(MeanStd {
            mean,
            std: (square - mean * mean).max(0.0).sqrt(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_population_deviation() {
        let mut moments = Moments::default();
        moments
            .add(&[2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0])
            .expect("finite");
        let (mean, std) = (5.0, 2.0);
        assert_eq!(moments.mean_std(), Some(MeanStd { mean, std }));
        assert_eq!(moments.count(), 8);
    }

    #[test]
    fn no_value_has_no_mean() {
        assert_eq!(Moments::default().mean_std(), None);
    }

    #[test]
    fn a_bad_value_is_named_and_leaves_the_sums_alone() {
        let mut moments = Moments::default();
        for bad in [f64::NAN, f64::INFINITY, 1.1e4] {
            let error = moments.add(&[1.0, bad]).unwrap_err();
            assert!(matches!(error, NormalizationError::Value { index: 1, .. }));
        }
        assert_eq!(moments, Moments::default());
    }

    #[test]
    fn order_and_sharding_do_not_change_a_bit() {
        let values: Vec<f64> = (1..1000)
            .map(|i| (f64::from(i) * 0.7).sin() / f64::from(i))
            .collect();
        let mut whole = Moments::default();
        whole.add(&values).expect("finite");
        let mut merged = Moments::default();
        for shard in values.chunks(7).rev() {
            let mut part = Moments::default();
            part.add(shard).expect("finite");
            merged.merge(&part);
        }
        assert_eq!(whole, merged);
        // Beside a large value all steps are counted in 128 bits.
        let mut beside = Moments::default();
        beside
            .add(&[&values[..], &[-3.0]].concat())
            .expect("finite");
        whole.add(&[-3.0]).expect("finite");
        assert_eq!(whole, beside);
    }
}
