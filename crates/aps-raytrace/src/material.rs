//! Materials of walls, and their effect on a reflected wave.

use std::ops::RangeInclusive;
use std::str::FromStr;

use num_complex::Complex64;

use crate::error::ConfigError;
use crate::ranges::{MAX_CONDUCTIVITY_S_PER_M, MAX_PERMITTIVITY};

/// Speed of light in vacuum \[m/s\], exact by definition of the metre.
pub const SPEED_OF_LIGHT_M_PER_S: f64 = 299_792_458.0;

/// Vacuum permittivity \[F/m\] (CODATA 2018).
pub const VACUUM_PERMITTIVITY_F_PER_M: f64 = 8.854_187_812_8e-12;

/// The electrical description of a wall.
///
/// ```
/// use aps_raytrace::Material;
///
/// let wall = Material::Concrete.at(3.5e9);
/// // Head-on it gives back -8 dB, grazing all of it.
/// assert!((20.0 * wall.reflection(1.0).norm().log10() + 8.1).abs() < 0.1);
/// assert!((wall.reflection(0.0) + 1.0).norm() < 1e-12);
/// assert_eq!(Material::PerfectConductor.at(3.5e9).reflection(0.3).re, -1.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Material {
    /// Concrete after ITU-R P.2040-3, table 3: relative permittivity 5.24, conductivity
    /// 0.0462 f^0.7822 S/m with f in GHz, stated for 1 to 100 GHz and continued beyond.
    ///
    /// P.2040-4 keeps that row and adds one for 110 to 330 GHz, which is not used: one curve for all
    /// carriers has no step between the two.
    #[default]
    Concrete,
    /// Perfect electric conductor: reflection coefficient -1 at every angle.
    PerfectConductor,
    /// User values, taken to hold at the carrier.
    Dielectric {
        /// Real relative permittivity, 1 to 1e9.
        relative_permittivity: f64,
        /// Conductivity \[S/m\], 0 to 1e12.
        conductivity_s_per_m: f64,
    },
}

/// The publication that a material's values are from.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MaterialSource {
    /// Document, edition and table.
    pub document: &'static str,
    /// Carriers that it states the values for \[Hz\].
    pub carriers_hz: RangeInclusive<f64>,
}

impl Material {
    /// Source of the values; `None` for those that no table states: the perfect conductor's and the user's.
    ///
    /// ```
    /// let source = aps_raytrace::Material::Concrete.source().expect("a table");
    /// assert_eq!(source.document, "ITU-R P.2040-3, table 3");
    /// assert!(source.carriers_hz.contains(&3.5e9) && !source.carriers_hz.contains(&923e6));
    /// ```
    #[must_use]
    pub fn source(self) -> Option<MaterialSource> {
        match self {
            Self::Concrete => Some(MaterialSource {
                document: "ITU-R P.2040-3, table 3",
                carriers_hz: 1e9..=100e9,
            }),
            Self::PerfectConductor | Self::Dielectric { .. } => None,
        }
    }

    /// Checks user values.
    ///
    /// # Errors
    /// [`ConfigError::Material`] when a value is outside its range.
    pub fn validate(self) -> Result<Self, ConfigError> {
        if let Self::Dielectric {
            relative_permittivity: eps,
            conductivity_s_per_m: sigma,
        } = self
            && !((1.0..=MAX_PERMITTIVITY).contains(&eps)
                && (0.0..=MAX_CONDUCTIVITY_S_PER_M).contains(&sigma))
        {
            return Err(ConfigError::Material {
                relative_permittivity: eps,
                conductivity_s_per_m: sigma,
            });
        }
        Ok(self)
    }

    /// The material at one carrier.
    #[must_use]
    pub fn at(self, frequency_hz: f64) -> Reflector {
        let (eps, sigma) = match self {
            Self::PerfectConductor => return Reflector { permittivity: None },
            Self::Concrete => (5.24, 0.0462 * (frequency_hz / 1e9).powf(0.7822)),
            Self::Dielectric {
                relative_permittivity,
                conductivity_s_per_m,
            } => (relative_permittivity, conductivity_s_per_m),
        };
        let omega = std::f64::consts::TAU * frequency_hz;
        let loss = sigma / (omega * VACUUM_PERMITTIVITY_F_PER_M);
        Reflector {
            permittivity: Some(Complex64::new(eps, -loss)),
        }
    }
}

impl FromStr for Material {
    type Err = ConfigError;

    /// Reads `concrete`, `pec` (perfect conductor) or `EPS,SIGMA`: relative permittivity and conductivity \[S/m\].
    ///
    /// ```
    /// use aps_raytrace::Material;
    ///
    /// assert_eq!("pec".parse(), Ok(Material::PerfectConductor));
    /// let brick = Material::Dielectric { relative_permittivity: 3.91, conductivity_s_per_m: 0.0238 };
    /// assert_eq!("3.91,0.0238".parse(), Ok(brick));
    /// assert!("gold".parse::<Material>().is_err() && "NaN,1".parse::<Material>().is_err());
    /// ```
    fn from_str(text: &str) -> Result<Self, ConfigError> {
        let number = |text: &str| text.trim().parse().ok();
        match text {
            "concrete" => Ok(Self::Concrete),
            "pec" => Ok(Self::PerfectConductor),
            _ => text
                .split_once(',')
                .and_then(|(eps, sigma)| number(eps).zip(number(sigma)))
                .ok_or_else(|| ConfigError::UnknownMaterial(text.into()))
                .and_then(|(relative_permittivity, conductivity_s_per_m)| {
                    let values = Self::Dielectric {
                        relative_permittivity,
                        conductivity_s_per_m,
                    };
                    values.validate()
                }),
        }
    }
}

/// A material at one carrier: all that a reflection needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflector {
    /// Complex relative permittivity (time factor e^{+j omega t}); none for a perfect conductor.
    permittivity: Option<Complex64>,
}

impl Reflector {
    /// Fresnel coefficient for the electric field perpendicular to the plane of incidence
    /// (vertical polarisation on vertical walls), from the cosine of the angle of incidence
    /// measured from the normal, in 0..=1:
    /// (cos - sqrt(eps - sin^2)) / (cos + sqrt(eps - sin^2)).
    ///
    /// 0 throughout for a wall of vacuum. Else it tends to -1 at grazing incidence and to (1 - sqrt(eps)) / (1 + sqrt(eps)) at normal
    /// incidence; exactly -1 for a perfect conductor. Its magnitude never exceeds 1.
    #[inline]
    #[must_use]
    pub fn reflection(self, cos_incidence: f64) -> Complex64 {
        let Some(eps) = self.permittivity else {
            return Complex64::new(-1.0, 0.0);
        };
        // Electrically no wall. The formula has 0 / 0 at grazing incidence.
        if eps == Complex64::ONE {
            return Complex64::ZERO;
        }
        let c = cos_incidence.clamp(0.0, 1.0);
        // eps - sin^2, without the rounding of 1 - cos^2: next to grazing it is all there is
        // of a wall that is hardly denser than air.
        let root = (eps - 1.0 + c * c).sqrt();
        (c - root) / (c + root)
    }

    /// Derivative of the reflection coefficient by the angle from the wall, for a ray along it \[1/rad\]: 2 / sqrt(eps - 1), and 0 for
    /// a perfect conductor and for a wall of vacuum.
    pub(crate) fn grazing_slope(self) -> Complex64 {
        match self.permittivity {
            Some(eps) if eps != Complex64::ONE => 2.0 / (eps - 1.0).sqrt(),
            _ => Complex64::ZERO,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grazing_incidence_reflects_with_minus_one() {
        for m in [Material::Concrete, Material::PerfectConductor] {
            let g = m.at(3.5e9).reflection(0.0);
            assert!((g + 1.0).norm() < 1e-15, "{m:?}: {g}");
        }
    }

    #[test]
    fn normal_incidence_matches_the_closed_form() {
        let r = Material::Concrete.at(3.5e9);
        let root = r.permittivity.unwrap().sqrt();
        let expected = (1.0 - root) / (1.0 + root);
        assert!((r.reflection(1.0) - expected).norm() < 1e-15);
    }

    #[test]
    fn concrete_at_3_5_ghz_has_the_tabulated_loss() {
        // sigma = 0.0462 * 3.5^0.7822 = 0.12309 S/m; eps'' = sigma / (omega eps0) = 0.6322.
        let eps = Material::Concrete.at(3.5e9).permittivity.unwrap();
        assert_eq!(eps.re, 5.24);
        assert!((eps.im + 0.6322).abs() < 2e-4, "{eps}");
    }

    #[test]
    fn magnitude_never_exceeds_one() {
        for i in 0..=1000 {
            let g = Material::Concrete
                .at(3.5e9)
                .reflection(f64::from(i) / 1000.0);
            assert!(g.norm() <= 1.0 + 1e-15);
        }
    }

    #[test]
    fn unphysical_values_are_refused() {
        let bad = Material::Dielectric {
            relative_permittivity: 0.5,
            conductivity_s_per_m: 0.0,
        };
        assert!(bad.validate().is_err());
    }
}
