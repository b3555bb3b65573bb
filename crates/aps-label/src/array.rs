//! Receiving arrays and their response to one plane wave.

use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

use crate::ConfigError;
use crate::limits::{MAX_ELEMENTS, MAX_WAVELENGTHS};
use crate::trig::{cos_pi, sin_pi};

/// The receiving array whose beam scans the azimuth.
///
/// ```
/// use aps_label::Array;
/// use std::f64::consts::PI;
///
/// let linear = Array::UniformLinear { elements: 16, spacing_wavelengths: 0.5 };
/// assert!(linear.power_response(PI - 0.4, 0.4) > 0.999); // the mirror twin
/// let circular = Array::UniformCircular { elements: 16, radius_wavelengths: 1.0 };
/// assert!(circular.power_response(PI - 0.4, 0.4) < 0.1); // has none
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum Array {
    /// Equally spaced elements on the y axis, broadside towards +x and -x: the benchmark's array.
    ///
    /// It sees only sin(theta), so that every path makes two equal peaks, at theta and at
    /// 180 deg - theta. Half a wavelength apart, the directions +90 and -90 deg alias as well.
    UniformLinear {
        /// N, the number of elements.
        elements: usize,
        /// d_lambda, the distance of neighbours \[wavelengths\].
        spacing_wavelengths: f64,
    },
    /// Elements on a circle, the first towards +x: no ambiguity in the plane.
    UniformCircular {
        /// N, the number of elements.
        elements: usize,
        /// Radius of the circle \[wavelengths\].
        radius_wavelengths: f64,
    },
}

impl Array {
    /// Power gain, normalised to 1, of the beam steered to `theta_rad` for a plane wave from
    /// `theta_k_rad` \[rad\]: in \[0, 1\] up to rounding.
    ///
    /// The linear array's is \[sin(N psi) / (N sin psi)\]^2 with
    /// psi = pi d_lambda (sin theta - sin theta_k); the circular one's is the squared mean over its
    /// elements of exp(2 pi j r \[cos(theta - phi_m) - cos(theta_k - phi_m)\]). The difference in
    /// the brackets is taken as a product, so that nothing cancels near the steering direction.
    pub fn power_response(&self, theta_rad: f64, theta_k_rad: f64) -> f64 {
        let half_sum = 0.5 * (theta_rad + theta_k_rad);
        let half_difference = libm::sin(0.5 * (theta_rad - theta_k_rad));
        match *self {
            Self::UniformLinear {
                elements,
                spacing_wavelengths,
            } => {
                let n = elements as f64;
                let half_turns = spacing_wavelengths * 2.0 * libm::cos(half_sum) * half_difference;
                // sin psi and sin(N psi) change at most their sign with the nearest integer taken
                // out, which the square forgets; the difference is exact.
                let f = half_turns - half_turns.round_ties_even();
                let ratio = if f == 0.0 {
                    1.0
                } else {
                    sin_pi(n * f) / (n * sin_pi(f))
                };
                ratio * ratio
            }
            Self::UniformCircular {
                elements,
                radius_wavelengths,
            } => {
                let n = elements as f64;
                let (mut re, mut im) = (0.0, 0.0);
                for m in 0..elements {
                    let phi = TAU * m as f64 / n;
                    let half_turns =
                        -4.0 * radius_wavelengths * libm::sin(half_sum - phi) * half_difference;
                    re += cos_pi(half_turns);
                    im += sin_pi(half_turns);
                }
                (re * re + im * im) / (n * n)
            }
        }
    }

    /// Form, elements and spacing \[wavelengths\], as [`ArrayForm::array`] takes them.
    pub fn parts(&self) -> (ArrayForm, usize, f64) {
        match *self {
            Self::UniformLinear {
                elements,
                spacing_wavelengths,
            } => (ArrayForm::Ula, elements, spacing_wavelengths),
            Self::UniformCircular {
                elements,
                radius_wavelengths,
            } => {
                let spacing_wavelengths = TAU * radius_wavelengths / elements as f64;
                (ArrayForm::Uca, elements, spacing_wavelengths)
            }
        }
    }

    pub(crate) fn validate(&self) -> Result<(), ConfigError> {
        let (elements, field, value) = match *self {
            Self::UniformLinear {
                elements,
                spacing_wavelengths,
            } => (elements, "spacing_wavelengths", spacing_wavelengths),
            Self::UniformCircular {
                elements,
                radius_wavelengths,
            } => (elements, "radius_wavelengths", radius_wavelengths),
        };
        if !(1..=MAX_ELEMENTS).contains(&elements) {
            return Err(ConfigError::Elements { elements });
        }
        if !(value > 0.0 && value <= MAX_WAVELENGTHS) {
            return Err(ConfigError::Wavelengths { field, value });
        }
        Ok(())
    }
}

/// Form of an array, for settings that tell it apart from elements and spacing.
///
/// ```
/// use aps_label::{Array, ArrayForm};
///
/// let form: ArrayForm = "ula".parse()?;
/// let array = form.array(16, 0.5);
/// assert_eq!(array, Array::UniformLinear { elements: 16, spacing_wavelengths: 0.5 });
/// assert_eq!(array.parts(), (ArrayForm::Ula, 16, 0.5));
/// # Ok::<(), aps_label::ConfigError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum ArrayForm {
    /// Uniform and linear: sees a direction and its mirror image alike.
    Ula,
    /// Uniform and circular: sees every direction for itself.
    Uca,
}

impl ArrayForm {
    /// Both forms.
    pub const ALL: [Self; 2] = [Self::Ula, Self::Uca];

    /// `ula` or `uca`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ula => "ula",
            Self::Uca => "uca",
        }
    }

    /// The array of this form; neighbours on a circle are `spacing_wavelengths` apart along its arc.
    pub fn array(self, elements: usize, spacing_wavelengths: f64) -> Array {
        match self {
            Self::Ula => Array::UniformLinear {
                elements,
                spacing_wavelengths,
            },
            Self::Uca => Array::UniformCircular {
                elements,
                radius_wavelengths: elements as f64 * spacing_wavelengths / TAU,
            },
        }
    }
}

/// The name of the form.
impl fmt::Display for ArrayForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for ArrayForm {
    type Err = ConfigError;

    /// Reads `ula` or `uca`.
    fn from_str(name: &str) -> Result<Self, ConfigError> {
        let found = Self::ALL.into_iter().find(|form| form.name() == name);
        found.ok_or_else(|| ConfigError::ArrayForm(name.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    const ULA: Array = Array::UniformLinear {
        elements: 16,
        spacing_wavelengths: 0.5,
    };
    const UCA: Array = Array::UniformCircular {
        elements: 15,
        radius_wavelengths: 1.0,
    };

    #[test]
    fn steering_direction_has_gain_one() {
        for i in -20..=20 {
            let theta = f64::from(i) * 0.31;
            assert_eq!(ULA.power_response(theta, theta), 1.0);
            assert!((UCA.power_response(theta, theta) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn linear_array_cannot_tell_a_direction_from_its_mirror_image() {
        for i in -20..=20 {
            let theta = f64::from(i) * 0.15;
            assert!((ULA.power_response(PI - theta, theta) - 1.0).abs() < 1e-14);
            assert!(UCA.power_response(PI - theta, theta) <= 1.0);
        }
        assert!(UCA.power_response(PI - 0.3, 0.3) < 0.5);
    }

    #[test]
    fn half_wavelength_array_aliases_end_fire() {
        assert!((ULA.power_response(FRAC_PI_2, -FRAC_PI_2) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn first_null_is_where_the_formula_puts_it() {
        // N psi = pi, that is d_lambda sin(theta) = 1/16.
        assert!(ULA.power_response((0.125_f64).asin(), 0.0) < 1e-30);
    }

    #[test]
    fn single_element_sees_all_directions_alike() {
        let array = Array::UniformLinear {
            elements: 1,
            spacing_wavelengths: 0.5,
        };
        assert_eq!(array.power_response(1.0, -2.0), 1.0);
    }
}
