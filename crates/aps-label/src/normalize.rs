//! From a label in dB to a learning target.

use crate::{MeanStd, NormalizationError, Protocol};

/// Keeps the released per-sample standardisation from dividing by zero.
pub const SAMPLE_EPSILON: f64 = 1e-8;

/// Method by which an APS in dB becomes a learning target; the statistics are those of [`relative_power`] over the
/// training split.
///
/// ```
/// use aps_label::{MeanStd, Normalization, Protocol};
///
/// let train = MeanStd { mean: 0.2, std: 0.3 };
/// let mut values = [-80.0, -83.0, -90.0];
/// Normalization::of(Protocol::Paper, train).apply(&mut values)?;
/// assert!((values[0] - (1.0 - 0.2) / 0.3).abs() < 1e-12);
/// # Ok::<(), aps_label::NormalizationError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Normalization {
    /// The paper's: [`relative_power`], then minus the mean, divided by the deviation.
    Paper(MeanStd),
    /// The released code's: as `Paper`, then minus the sample's own mean, divided by its own
    /// population deviation + [`SAMPLE_EPSILON`].
    Released(MeanStd),
}

/// Power relative to the sample's maximum: subtracts the maximum in dB and goes to linear, in
/// place. Returns the maximum \[dB\]. The result is in \[0, 1\].
///
/// # Errors
///
/// No value, or one that is not finite, before or after the subtraction.
pub fn relative_power(values_db: &mut [f64]) -> Result<f64, NormalizationError> {
    check(values_db)?;
    let peak_db = values_db.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    values_db.iter_mut().for_each(|value| *value -= peak_db);
    check(values_db)?;
    for value in values_db.iter_mut() {
        *value = libm::exp10(0.1 * *value);
    }
    Ok(peak_db)
}

impl Normalization {
    /// Returns the method of a protocol.
    pub fn of(protocol: Protocol, train: MeanStd) -> Self {
        match protocol {
            Protocol::Paper => Self::Paper(train),
            Protocol::Released => Self::Released(train),
        }
    }

    /// dB to target, in place.
    ///
    /// # Errors
    ///
    /// No value, one that is not finite or becomes so (the values are then lost), or statistics that cannot be divided by.
    pub fn apply(&self, values: &mut [f64]) -> Result<(), NormalizationError> {
        relative_power(values)?;
        self.apply_to_power(values)
    }

    /// Power relative to the sample's maximum to target, in place.
    ///
    /// # Errors
    ///
    /// As [`Normalization::apply`].
    pub fn apply_to_power(&self, values: &mut [f64]) -> Result<(), NormalizationError> {
        let (Self::Paper(MeanStd { mean, std }) | Self::Released(MeanStd { mean, std })) = *self;
        if !(mean.is_finite() && std.is_finite() && std > 0.0) {
            return Err(NormalizationError::Statistics { mean, std });
        }
        check(values)?;
        for value in values.iter_mut() {
            *value = (*value - mean) / std;
        }
        if let Self::Released(_) = self {
            standardise(values);
        }
        check(values)
    }
}

/// Minus the mean, divided by the population deviation + [`SAMPLE_EPSILON`].
fn standardise(values: &mut [f64]) {
    let n = values.len() as f64;
    // From the first value: equal values have that mean, to the bit, and no deviation.
    let mean = values[0] + values.iter().map(|x| x - values[0]).sum::<f64>() / n;
    let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n;
    let std = variance.sqrt() + SAMPLE_EPSILON;
    values.iter_mut().for_each(|x| *x = (*x - mean) / std);
}

fn check(values: &[f64]) -> Result<(), NormalizationError> {
    if values.is_empty() {
        return Err(NormalizationError::Empty);
    }
    match values.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(NormalizationError::Value {
            index,
            value: values[index],
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const APS: [f64; 6] = [-91.5, -80.25, -100.0, -87.0, -120.0, -80.5];
    const SPLIT: MeanStd = MeanStd {
        mean: 0.17,
        std: 0.26,
    };

    #[test]
    fn paper_target_is_relative_power_minus_mean_over_deviation() {
        let mut values = APS;
        Normalization::Paper(SPLIT).apply(&mut values).unwrap();
        for (got, db) in values.iter().zip(APS) {
            let want = (10_f64.powf((db + 80.25) / 10.0) - 0.17) / 0.26;
            assert!((got - want).abs() < 1e-12, "{db}: {got} is not {want}");
        }
    }

    #[test]
    fn released_target_has_mean_zero_and_deviation_one() {
        let mut values = APS;
        Normalization::Released(SPLIT).apply(&mut values).unwrap();
        let mean = values.iter().sum::<f64>() / 6.0;
        let square = values.iter().map(|x| x * x).sum::<f64>() / 6.0;
        assert!(mean.abs() < 1e-15 && (square - 1.0).abs() < 1e-7);
    }

    #[test]
    fn flat_sample_is_zero_not_nan() {
        let mut values = [-70.0; 5];
        Normalization::Released(SPLIT).apply(&mut values).unwrap();
        assert!(values.iter().all(|x| x.abs() < 1e-7), "{values:?}");
    }

    #[test]
    fn bad_input_is_an_error() {
        let paper = Normalization::Paper(SPLIT);
        assert_eq!(paper.apply(&mut []), Err(NormalizationError::Empty));
        let error = paper.apply(&mut [0.0, f64::INFINITY]).unwrap_err();
        assert!(matches!(error, NormalizationError::Value { index: 1, .. }));
        for (mean, std) in [(0.0, 0.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
            assert!(matches!(
                Normalization::Paper(MeanStd { mean, std }).apply(&mut [1.0]),
                Err(NormalizationError::Statistics { .. })
            ));
        }
    }
}
