//! Settings of a label.

use crate::limits::{MAX_DELAY_POINTS, MAX_DELAY_S, SAMPLING_RATE_HZ};
use crate::{Array, Axis, ConfigError, Protocol};

/// Everything a label depends on besides the paths.
///
/// ```
/// use aps_label::{Array, LabelConfig, Labeler};
///
/// let config = LabelConfig {
///     array: Array::UniformCircular { elements: 16, radius_wavelengths: 1.0 },
///     ..LabelConfig::paper()
/// };
/// assert!(Labeler::new(&config).is_ok());
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LabelConfig {
    /// The definition of the label.
    pub protocol: Protocol,
    /// f_s, the bandwidth-related sampling rate \[Hz\]; the pulse has its first zeros at 1/f_s.
    pub sampling_rate_hz: f64,
    /// The receiving array.
    pub array: Array,
    /// The sampled delays. `Released` takes its maximum over tau there; both protocols put the PDP
    /// there.
    pub delay_axis: DelayAxis,
    /// Computes the PDP too, when true.
    pub pdp: bool,
}

/// Equally spaced delays from 0 to `last_s`, both included.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DelayAxis {
    /// Number of points, at least 2.
    pub points: usize,
    /// The last delay \[s\], at most [`MAX_DELAY_S`].
    pub last_s: f64,
}

impl DelayAxis {
    /// The released code's axis: 128 points from 0 to 1000 ns, 7.87 ns apart.
    ///
    /// At f_s = 200 MHz this is coarser than the pulse's null spacing of 5 ns, so a sampled maximum
    /// falls short of the continuous one, by up to 12 dB for a single path.
    pub const RELEASED: Self = Self {
        points: 128,
        last_s: 1e-6,
    };

    /// 401 points from 0 to 1000 ns: at f_s = 200 MHz 1/(2 f_s) = 2.5 ns apart.
    ///
    /// The pulse has no frequencies beyond f_s, so these samples determine the profile, and the
    /// largest is at most 3 dB below the continuous maximum.
    pub const HALF_SAMPLE: Self = Self {
        points: 401,
        last_s: 1e-6,
    };

    /// The delays \[s\].
    pub(crate) fn delays_s(self) -> Vec<f64> {
        self.axis(self.last_s).values().collect()
    }

    /// The delays \[ns\].
    pub fn axis_ns(self) -> Axis {
        self.axis(self.last_s * 1e9)
    }

    fn axis(self, last: f64) -> Axis {
        Axis {
            start: 0.0,
            stop: last,
            count: self.points,
            endpoint: true,
        }
    }
}

impl LabelConfig {
    /// The released code's definition: 16 elements half a wavelength apart, f_s = 200 MHz,
    /// [`DelayAxis::RELEASED`], no PDP.
    pub fn released() -> Self {
        Self {
            protocol: Protocol::Released,
            sampling_rate_hz: 200e6,
            array: Array::UniformLinear {
                elements: 16,
                spacing_wavelengths: 0.5,
            },
            delay_axis: DelayAxis::RELEASED,
            pdp: false,
        }
    }

    /// The paper's definition. What the paper does not give (f_s, the array) is as in
    /// [`released`](Self::released); the PDP, if asked for, is on [`DelayAxis::HALF_SAMPLE`].
    pub fn paper() -> Self {
        Self {
            protocol: Protocol::Paper,
            delay_axis: DelayAxis::HALF_SAMPLE,
            ..Self::released()
        }
    }

    /// The preset of a protocol.
    pub fn of(protocol: Protocol) -> Self {
        match protocol {
            Protocol::Paper => Self::paper(),
            Protocol::Released => Self::released(),
        }
    }

    /// Settings of this label under a protocol: array and bandwidth stay, the delay axis becomes the protocol's unless it was
    /// this protocol's already.
    pub fn under(&self, protocol: Protocol) -> Self {
        let delay_axis = match self.protocol == protocol {
            true => self.delay_axis,
            false => Self::of(protocol).delay_axis,
        };
        Self {
            protocol,
            delay_axis,
            ..self.clone()
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    ///
    /// The first field that is out of range, with its value and what is allowed.
    pub fn validate(&self) -> Result<(), ConfigError> {
        if !SAMPLING_RATE_HZ.contains(&self.sampling_rate_hz) {
            return Err(ConfigError::SamplingRate {
                value: self.sampling_rate_hz,
            });
        }
        self.array.validate()?;
        let DelayAxis { points, last_s } = self.delay_axis;
        if !(2..=MAX_DELAY_POINTS).contains(&points) {
            return Err(ConfigError::DelayPoints { points });
        }
        if !(last_s > 0.0 && last_s <= MAX_DELAY_S) {
            return Err(ConfigError::DelayEnd { value: last_s });
        }
        Ok(())
    }
}

impl Default for LabelConfig {
    /// The preset of the default protocol, [`LabelConfig::paper`].
    fn default() -> Self {
        Self::of(Protocol::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_valid() {
        for config in [LabelConfig::released(), LabelConfig::paper()] {
            assert_eq!(config.validate(), Ok(()));
        }
    }

    #[test]
    fn each_bad_field_is_named() {
        let base = LabelConfig::released();
        let error = |change: &dyn Fn(&mut LabelConfig)| {
            let mut config = base.clone();
            change(&mut config);
            config.validate().expect_err("a bad field")
        };
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let of_rate = error(&|config| config.sampling_rate_hz = bad);
            assert!(matches!(of_rate, ConfigError::SamplingRate { .. }));
            let of_end = error(&|config| config.delay_axis.last_s = bad);
            assert!(matches!(of_end, ConfigError::DelayEnd { .. }));
            let array = Array::UniformLinear {
                elements: 16,
                spacing_wavelengths: bad,
            };
            let of_spacing = error(&|config| config.array = array);
            assert!(matches!(of_spacing, ConfigError::Wavelengths { .. }));
        }
        for bad in [0, 1, usize::MAX] {
            let of_points = error(&|config| config.delay_axis.points = bad);
            assert!(matches!(of_points, ConfigError::DelayPoints { .. }));
        }
        let array = Array::UniformCircular {
            elements: 0,
            radius_wavelengths: 1.0,
        };
        let of_elements = error(&|config| config.array = array);
        assert_eq!(of_elements, ConfigError::Elements { elements: 0 });
        assert_eq!(
            of_elements.to_string(),
            "array of 0 elements: must be between 1 and 4096"
        );
    }

    #[test]
    fn delay_axes_have_the_published_ends() {
        let delays = DelayAxis::RELEASED.delays_s();
        assert_eq!((delays.len(), delays[0], delays[127]), (128, 0.0, 1e-6));
        let delays = DelayAxis::HALF_SAMPLE.delays_s();
        assert!((delays[1] - 2.5e-9).abs() < 1e-22);
    }
}
