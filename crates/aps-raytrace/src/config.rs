//! Settings of a trace.

use crate::error::ConfigError;
use crate::limits::Limits;
use crate::material::{Material, MaterialSource, SPEED_OF_LIGHT_M_PER_S};
use crate::ranges::FREQUENCY_HZ;

/// Largest limit of reflections, of diffractions, and of those of fallback chains.
pub const MAX_INTERACTIONS: usize = 1000;

/// Settings of a trace: carrier, material and limits.
///
/// ```
/// use aps_raytrace::{Material, TraceConfig};
///
/// let indoors_at_28_ghz = TraceConfig {
///     frequency_hz: 28e9,
///     material: Material::Dielectric { relative_permittivity: 2.73, conductivity_s_per_m: 0.2 },
///     max_reflections: 4,
///     max_interactions: 5,
///     ..TraceConfig::default()
/// };
/// assert!(indoors_at_28_ghz.validate().is_ok());
/// assert!(TraceConfig { frequency_hz: -1.0, ..indoors_at_28_ghz }.validate().is_err());
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TraceConfig {
    /// Carrier \[Hz\], 1 to 1e18.
    pub frequency_hz: f64,
    /// Walls whose footprint names no material are made of this.
    pub material: Material,
    /// Most reflections on a path.
    pub max_reflections: usize,
    /// Most diffractions on a path.
    pub max_diffractions: usize,
    /// Most interactions on a path, of either kind.
    pub max_interactions: usize,
    /// Waves from corner to corner take their slope along: slope diffraction. Without it such paths are cascades of
    /// coefficients, and nothing goes along a perfectly conducting wall from corner to corner. With one diffraction at most it
    /// changes nothing. On by default; a serialized configuration of a version that did not know it reads as off.
    #[cfg_attr(feature = "serde", serde(default))]
    pub slope_diffraction: bool,
    /// Paths weaker than the link's strongest by more than this \[dB\] are left out; `None` keeps
    /// every path inside the limits.
    pub dynamic_range_db: Option<f64>,
    /// A link without any path inside the limits goes on with up to this many diffractions, along
    /// the best chains of mutually visible corners, whose levels are estimates; no more than `max_diffractions` or than
    /// `max_interactions`, as by default, turns it off.
    pub max_fallback_diffractions: usize,
    /// Most images of one terminal: a bound on memory (about 80 bytes each) where walls multiply
    /// them, as in a long corridor.
    pub max_images: usize,
    /// Most memory \[bytes\] for each of these: the walls that all corners see, the candidates, legs and waves of one terminal at
    /// corners, the legs between all corners, the graph of corners that see each other, the chains over it of one
    /// transmitter. What they hold is counted: while they grow they may take twice as much. A bound where corners multiply
    /// them, as round buildings of many vertices do, or many diffractions.
    pub max_wave_bytes: usize,
}

impl Default for TraceConfig {
    fn default() -> Self {
        Self {
            frequency_hz: 3.5e9,
            material: Material::Concrete,
            max_reflections: 2,
            max_diffractions: 1,
            max_interactions: 3,
            slope_diffraction: true,
            dynamic_range_db: Some(60.0),
            max_fallback_diffractions: 0,
            max_images: 10_000_000,
            max_wave_bytes: 1 << 30,
        }
    }
}

impl TraceConfig {
    /// The default with other limits on the reflections and on the diffractions of a path, and none on their sum.
    #[must_use]
    pub fn within(max_reflections: usize, max_diffractions: usize) -> Self {
        Self {
            max_reflections,
            max_diffractions,
            max_interactions: max_reflections.saturating_add(max_diffractions),
            ..Self::default()
        }
    }

    /// Five reflections, two diffractions, paths within 20 dB of the strongest: labels that a further reflection and weaker paths
    /// change by 1.0 dB in the mean, on maps of the paper (`cargo xtask report --study tracer`). Within 30 dB it is 0.8 dB. A third diffraction
    /// changes them by more: 1.2 to 1.5 dB on 120 links of four maps.
    #[must_use]
    pub fn converged() -> Self {
        Self {
            dynamic_range_db: Some(20.0),
            ..Self::within(5, 2)
        }
    }

    /// Reflections up to an order and nothing else, no path left out.
    #[must_use]
    pub fn reflections_only(max_reflections: usize) -> Self {
        Self {
            dynamic_range_db: None,
            max_fallback_diffractions: 0,
            ..Self::within(max_reflections, 0)
        }
    }

    /// Wavelength of the carrier \[m\]. The formulas are those of the far field: of a path that is not
    /// longer they say too much, from a twelfth of it down even a gain above 0 dB.
    #[must_use]
    pub fn wavelength_m(&self) -> f64 {
        SPEED_OF_LIGHT_M_PER_S / self.frequency_hz
    }

    /// The source of the material's values, where it does not state them for this carrier; they are then continued.
    #[must_use]
    pub fn material_out_of_range(&self) -> Option<MaterialSource> {
        let source = self.material.source();
        source.filter(|source| !source.carriers_hz.contains(&self.frequency_hz))
    }

    /// Checks every setting.
    ///
    /// # Errors
    /// [`ConfigError`] for the first one outside its range.
    pub fn validate(&self) -> Result<(), ConfigError> {
        if !FREQUENCY_HZ.contains(&self.frequency_hz) {
            return Err(ConfigError::Frequency(self.frequency_hz));
        }
        if let Some(range) = self.dynamic_range_db
            && !(range.is_finite() && range >= 0.0)
        {
            return Err(ConfigError::DynamicRange(range));
        }
        for (name, value) in [
            ("max_reflections", self.max_reflections),
            ("max_diffractions", self.max_diffractions),
            ("max_fallback_diffractions", self.max_fallback_diffractions),
        ] {
            if value > MAX_INTERACTIONS {
                return Err(ConfigError::TooManyInteractions {
                    name,
                    value,
                    limit: MAX_INTERACTIONS,
                });
            }
        }
        self.material.validate()?;
        Ok(())
    }

    /// Reflections that any path can have.
    pub(crate) fn reflection_limit(&self) -> usize {
        self.max_reflections.min(self.max_interactions)
    }

    /// Diffractions that any path can have.
    pub(crate) fn diffraction_limit(&self) -> usize {
        self.max_diffractions.min(self.max_interactions)
    }

    pub(crate) fn limits(&self) -> Limits {
        let clamp = |v: usize| v.min(2 * MAX_INTERACTIONS) as u32;
        Limits {
            reflections: clamp(self.max_reflections),
            diffractions: clamp(self.max_diffractions),
            interactions: clamp(self.max_interactions),
            bytes: self.max_wave_bytes,
        }
    }

    /// Returns true when links without a path within the limits go on to more diffractions.
    pub(crate) fn has_fallback(&self) -> bool {
        self.max_fallback_diffractions > self.diffraction_limit()
    }
}
