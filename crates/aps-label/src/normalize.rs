//! From a label in dB to a learning target, and back.

use crate::MeanStd;

/// Keeps the released per-sample standardisation from dividing by zero.
pub const SAMPLE_EPSILON: f64 = 1e-8;

/// Linear power at least this relative to a sample's maximum when a prediction goes back to dB
/// (-350 dB): a predicted power may be zero or negative.
const FLOOR: f64 = 1e-35;

/// Method by which an APS in dB becomes a learning target.
///
/// ```
/// use aps_label::{MeanStd, Normalization};
///
/// let paper = Normalization::Paper(MeanStd { mean: 0.2, std: 0.3 });
/// let mut values = [-80.0, -83.0, -90.0];
/// let scale = paper.apply(&mut values)?;
/// assert!((values[0] - (1.0 - 0.2) / 0.3).abs() < 1e-12);
/// paper.invert(&scale, &mut values)?;
/// assert!((values[1] + 83.0).abs() < 1e-12);
/// # Ok::<(), aps_label::NormalizationError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Normalization {
    /// The paper's: [`relative_power`], then minus the mean, divided by the deviation of
    /// `relative_power` over the training split.
    Paper(MeanStd),
    /// The released code's: as `Paper`, then minus the sample's own mean, divided by its own
    /// population deviation + [`SAMPLE_EPSILON`].
    Released(MeanStd),
    /// 2x - 1 with x = (dB - low)/(high - low), of the dB values as given.
    MinMax {
        /// dB that becomes -1, the least of the training split.
        low_db: f64,
        /// dB that becomes +1, the largest of the training split.
        high_db: f64,
    },
    /// (dB - mean)/deviation of the dB values as given, with those of the training split.
    ZScore(MeanStd),
}

/// Values that normalisation took from one sample: needed to undo it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SampleScale {
    /// The sample's maximum \[dB\]; 0 where the method does not subtract it.
    pub peak_db: f64,
    /// The sample's own mean and deviation (with its epsilon); 0 and 1 where the method does not
    /// use them.
    pub own: MeanStd,
}

/// Why values could not be normalised.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NormalizationError {
    /// There is no value; a link without a path has no label and is left out.
    #[error("no values to normalise: leave links without a path out")]
    Empty,
    /// A value is not finite, or too large for a sum.
    #[error("value {index} is {value}: must be finite and within the range of a power in dB")]
    Value {
        /// Its position.
        index: usize,
        /// The value.
        value: f64,
    },
    /// The statistics cannot be divided by.
    #[error(
        "mean {mean}, spread {spread}: the mean must be finite, the spread finite and positive"
    )]
    Statistics {
        /// Mean, or the lower end of the range.
        mean: f64,
        /// Standard deviation, or the width of the range.
        spread: f64,
    },
}

/// Power relative to the sample's maximum: subtracts the maximum in dB and goes to linear, in
/// place. Returns the maximum \[dB\]. The result is in \[0, 1\].
///
/// # Errors
///
/// No value, or one that is not finite.
pub fn relative_power(values_db: &mut [f64]) -> Result<f64, NormalizationError> {
    let peak_db = relative_db(values_db)?;
    for value in values_db.iter_mut() {
        *value = libm::exp10(0.1 * *value);
    }
    Ok(peak_db)
}

/// Subtracts the sample's maximum, in place, and returns it \[dB\].
///
/// # Errors
///
/// No value, or one that is not finite, before or after.
pub fn relative_db(values_db: &mut [f64]) -> Result<f64, NormalizationError> {
    check(values_db)?;
    let peak_db = values_db.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    values_db.iter_mut().for_each(|value| *value -= peak_db);
    check(values_db)?;
    Ok(peak_db)
}

impl Normalization {
    /// dB to target, in place.
    ///
    /// # Errors
    ///
    /// No value, one that is not finite or becomes so (the values are then lost), or statistics that cannot be divided by.
    pub fn apply(&self, values: &mut [f64]) -> Result<SampleScale, NormalizationError> {
        let (shift, spread) = self.affine()?;
        let peak_db = match self {
            Self::Paper(_) | Self::Released(_) => relative_power(values)?,
            Self::MinMax { .. } | Self::ZScore(_) => {
                check(values)?;
                0.0
            }
        };
        values
            .iter_mut()
            .for_each(|value| *value = (*value - shift) / spread);
        let own = match self {
            Self::Released(_) => standardise(values),
            _ => MeanStd {
                mean: 0.0,
                std: 1.0,
            },
        };
        check(values)?;
        Ok(SampleScale { peak_db, own })
    }

    /// Target to dB, in place: the inverse of [`apply`](Self::apply), for truth or a prediction.
    ///
    /// Where only the shape is known (a prediction), `peak_db` = 0 gives dB relative to the
    /// maximum. Powers of zero and below become -350 dB relative to the maximum; so do labels below
    /// that, which linear power in f64 has lost against the mean long before (below -150 dB).
    ///
    /// # Errors
    ///
    /// No value, one that is not finite, or statistics that cannot be divided by.
    pub fn invert(
        &self,
        scale: &SampleScale,
        values: &mut [f64],
    ) -> Result<(), NormalizationError> {
        check(values)?;
        let (shift, spread) = self.affine()?;
        let MeanStd { mean, std } = scale.own;
        if !(mean.is_finite() && std.is_finite() && std > 0.0) {
            return Err(NormalizationError::Statistics { mean, spread: std });
        }
        for value in values.iter_mut() {
            let x = (*value * std + mean) * spread + shift;
            *value = match self {
                Self::Paper(_) | Self::Released(_) => {
                    10.0 * libm::log10(x.max(FLOOR)) + scale.peak_db
                }
                Self::MinMax { .. } | Self::ZScore(_) => x,
            };
        }
        check(values)
    }

    /// Target = (value - shift) / spread.
    fn affine(&self) -> Result<(f64, f64), NormalizationError> {
        let (shift, spread) = match *self {
            Self::Paper(MeanStd { mean, std })
            | Self::Released(MeanStd { mean, std })
            | Self::ZScore(MeanStd { mean, std }) => (mean, std),
            Self::MinMax { low_db, high_db } => {
                (0.5 * (low_db + high_db), 0.5 * (high_db - low_db))
            }
        };
        if shift.is_finite() && spread.is_finite() && spread > 0.0 {
            Ok((shift, spread))
        } else {
            Err(NormalizationError::Statistics {
                mean: shift,
                spread,
            })
        }
    }
}

/// Minus the mean, divided by the population deviation + [`SAMPLE_EPSILON`]; returns both.
fn standardise(values: &mut [f64]) -> MeanStd {
    let n = values.len() as f64;
    // From the first value: equal values have that mean, to the bit, and no deviation.
    let mean = values[0] + values.iter().map(|x| x - values[0]).sum::<f64>() / n;
    let variance = values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n;
    let std = variance.sqrt() + SAMPLE_EPSILON;
    values.iter_mut().for_each(|x| *x = (*x - mean) / std);
    MeanStd { mean, std }
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
    const SPLIT_DB: MeanStd = MeanStd {
        mean: -95.0,
        std: 14.0,
    };

    fn applied(method: Normalization) -> ([f64; 6], SampleScale) {
        let mut values = APS;
        let scale = method.apply(&mut values).expect("good values");
        (values, scale)
    }

    #[test]
    fn every_method_is_undone() {
        for method in [
            Normalization::Paper(SPLIT),
            Normalization::Released(SPLIT),
            Normalization::MinMax {
                low_db: -350.0,
                high_db: -60.0,
            },
            Normalization::ZScore(SPLIT_DB),
        ] {
            let (mut values, scale) = applied(method);
            method.invert(&scale, &mut values).expect("good values");
            for (got, want) in values.iter().zip(APS) {
                assert!((got - want).abs() < 1e-9, "{method:?}: {got} is not {want}");
            }
        }
    }

    #[test]
    fn released_target_has_mean_zero_and_deviation_one() {
        let (values, _) = applied(Normalization::Released(SPLIT));
        let mean = values.iter().sum::<f64>() / 6.0;
        let square = values.iter().map(|x| x * x).sum::<f64>() / 6.0;
        assert!(mean.abs() < 1e-15 && (square - 1.0).abs() < 1e-7);
    }

    #[test]
    fn flat_sample_is_zero_not_nan() {
        let mut values = [-70.0; 5];
        let scale = Normalization::Released(SPLIT)
            .apply(&mut values)
            .expect("good values");
        assert!(values.iter().all(|x| x.abs() < 1e-7), "{values:?}");
        assert_eq!(scale.peak_db, -70.0);
    }

    #[test]
    fn min_max_ends_are_minus_one_and_one() {
        let (values, _) = applied(Normalization::MinMax {
            low_db: -120.0,
            high_db: -80.25,
        });
        assert_eq!((values[4], values[1]), (-1.0, 1.0));
    }

    #[test]
    fn impossible_power_of_a_prediction_is_floored() {
        let mut values = [-5.0, 3.0];
        let scale = SampleScale {
            peak_db: 0.0,
            own: MeanStd {
                mean: 0.0,
                std: 1.0,
            },
        };
        Normalization::Paper(SPLIT)
            .invert(&scale, &mut values)
            .expect("good values");
        assert_eq!(values[0], -350.0);
    }

    #[test]
    fn bad_input_is_an_error() {
        let paper = Normalization::Paper(SPLIT);
        assert_eq!(paper.apply(&mut []), Err(NormalizationError::Empty));
        let error = paper.apply(&mut [0.0, f64::INFINITY]).unwrap_err();
        assert!(matches!(error, NormalizationError::Value { index: 1, .. }));
        for bad in [
            Normalization::Paper(MeanStd {
                mean: 0.0,
                std: 0.0,
            }),
            Normalization::ZScore(MeanStd {
                mean: f64::NAN,
                std: 1.0,
            }),
            Normalization::MinMax {
                low_db: -60.0,
                high_db: -60.0,
            },
        ] {
            assert!(matches!(
                bad.apply(&mut [1.0]),
                Err(NormalizationError::Statistics { .. })
            ));
        }
    }
}
