//! The settings of a data set as its manifest keeps them, and read back.
//!
//! Everything a link depends on is there: `maps` (their kind), `scene`, `sampling`, `trace`, `label`, and the seed beside them. So
//! a stored data set can be labelled anew, and its links computed again and compared.

mod error;

use aps_label::LabelConfig;
use aps_raytrace::{Material, TraceConfig};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::error::Result;
use crate::limits::has_legs_between_corners;
use crate::maps::SceneSettings;
use crate::sampling::Sampling;

pub use error::SettingsError;

/// The `configuration` of a traced data set; `maps` says what kind they are of.
pub(crate) fn of_traced(
    maps: Value,
    scene: SceneSettings,
    sampling: Sampling,
    trace: &TraceConfig,
    label: &LabelConfig,
) -> Value {
    json!({
        "maps": maps,
        "scene": scene,
        "sampling": sampling,
        "trace": TraceSettings::of(trace),
        "label": label,
    })
}

/// Reads the settings of one name in a `configuration`, if they are there.
fn read<T: DeserializeOwned>(
    configuration: &Value,
    name: &'static str,
) -> Result<Option<T>, SettingsError> {
    let value = configuration.get(name).cloned();
    let read = value.map(serde_json::from_value).transpose();
    read.map_err(|source| SettingsError::Unknown { name, source })
}

/// Reads the label settings in the `configuration` of a manifest.
///
/// # Errors
/// Settings that are not there, and unknown ones.
pub fn label_of(configuration: &Value) -> Result<LabelConfig, SettingsError> {
    read(configuration, "label")?.ok_or(SettingsError::None("label"))
}

/// Reads the scene settings in a `configuration`. An import has the usual ones; of other data sets of format
/// version 1 no slit was filled.
///
/// # Errors
/// Unknown settings.
pub fn scene_of(configuration: &Value) -> Result<SceneSettings, SettingsError> {
    let mut none = SceneSettings::default();
    if configuration.get("import").is_none() {
        none.close_gaps_m = 0.0;
    }
    Ok(read(configuration, "scene")?.unwrap_or(none))
}

/// Reads the settings of terminals and trace in a `configuration`; `None` if the data set was not traced here.
///
/// # Errors
/// Unknown settings, and limits out of range.
pub fn tracing_of(configuration: &Value) -> Result<Option<(Sampling, TraceConfig)>> {
    let (Some(trace), Some(_)) = (
        read::<TraceSettings>(configuration, "trace")?,
        configuration.get("sampling"),
    ) else {
        return Ok(None);
    };
    let sampling = read(configuration, "sampling")?;
    let trace = trace.config()?;
    Ok(sampling.map(|sampling| (sampling, trace)))
}

/// [`TraceConfig`] without `max_images` and `max_wave_bytes`, which decide whether a map can be traced, not what comes out.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TraceSettings {
    frequency_hz: f64,
    material: MaterialSetting,
    /// Document, edition and table that the material's values are from. Missing in older manifests.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    material_source: Option<String>,
    max_reflections: usize,
    max_diffractions: usize,
    max_interactions: usize,
    /// Missing where it is off, as in manifests of versions that had none, and where it changes nothing: see [`has_legs_between_corners`].
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    slope_diffraction: bool,
    dynamic_range_db: Option<f64>,
    /// A setting of earlier versions. Without a value it decides nothing.
    #[serde(default, skip_serializing)]
    accuracy_db: Option<f64>,
    max_fallback_diffractions: usize,
}

/// `"concrete"`, `"pec"`, or relative permittivity and conductivity [S/m].
#[derive(Debug, Serialize, Deserialize)]
#[serde(untagged)]
enum MaterialSetting {
    Named(String),
    Values([f64; 2]),
}

impl TraceSettings {
    fn of(config: &TraceConfig) -> Self {
        Self {
            frequency_hz: config.frequency_hz,
            material: match config.material {
                Material::Concrete => MaterialSetting::Named("concrete".into()),
                Material::PerfectConductor => MaterialSetting::Named("pec".into()),
                Material::Dielectric {
                    relative_permittivity,
                    conductivity_s_per_m,
                } => MaterialSetting::Values([relative_permittivity, conductivity_s_per_m]),
            },
            material_source: config.material.source().map(|s| s.document.into()),
            max_reflections: config.max_reflections,
            max_diffractions: config.max_diffractions,
            max_interactions: config.max_interactions,
            slope_diffraction: config.slope_diffraction
                && has_legs_between_corners(config.max_diffractions, config.max_interactions),
            dynamic_range_db: config.dynamic_range_db,
            accuracy_db: None,
            max_fallback_diffractions: config.max_fallback_diffractions,
        }
    }

    fn config(self) -> Result<TraceConfig> {
        if let Some(accuracy_db) = self.accuracy_db {
            return Err(SettingsError::Accuracy(accuracy_db).into());
        }
        let material = match self.material {
            MaterialSetting::Named(name) => {
                let known = name.parse();
                known.map_err(|_| SettingsError::Material(name))?
            }
            MaterialSetting::Values([relative_permittivity, conductivity_s_per_m]) => {
                Material::Dielectric {
                    relative_permittivity,
                    conductivity_s_per_m,
                }
            }
        };
        let config = TraceConfig {
            frequency_hz: self.frequency_hz,
            material,
            max_reflections: self.max_reflections,
            max_diffractions: self.max_diffractions,
            max_interactions: self.max_interactions,
            slope_diffraction: self.slope_diffraction
                || !has_legs_between_corners(self.max_diffractions, self.max_interactions),
            dynamic_range_db: self.dynamic_range_db,
            max_fallback_diffractions: self.max_fallback_diffractions,
            ..TraceConfig::default()
        };
        config.validate()?;
        Ok(config)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_read_back_as_they_were() {
        let sampling = Sampling {
            tx_per_map: 3,
            rx_per_map: 7,
            grid_m: 1.0,
            receivers: crate::sampling::Receivers::Reached,
        };
        let label = LabelConfig {
            sampling_rate_hz: 123.4e6,
            ..LabelConfig::paper()
        };
        for (material, stored) in [
            ("concrete", json!("concrete")),
            ("pec", json!("pec")),
            ("6.1,0.03", json!([6.1, 0.03])),
        ] {
            let material: Material = material.parse().unwrap();
            let trace = TraceConfig {
                material,
                dynamic_range_db: None,
                frequency_hz: 0.1 + 28e9,
                max_diffractions: 2,
                slope_diffraction: material == Material::PerfectConductor,
                ..TraceConfig::default()
            };
            let written = of_traced(
                json!("synthetic"),
                SceneSettings::default(),
                sampling,
                &trace,
                &label,
            )
            .to_string();
            let read: Value = serde_json::from_str(&written).unwrap();
            assert_eq!(read["trace"]["material"], stored);
            assert_eq!(tracing_of(&read).unwrap(), Some((sampling, trace)));
            assert_eq!(label_of(&read).unwrap(), label);
        }
    }

    #[test]
    fn slopes_are_named_only_where_they_change_something() {
        let default = TraceConfig::default();
        let written = |trace: &TraceConfig| serde_json::to_value(TraceSettings::of(trace)).unwrap();
        let read = |settings: Value| -> TraceConfig {
            let settings: TraceSettings = serde_json::from_value(settings).unwrap();
            settings.config().unwrap()
        };
        for slope_diffraction in [false, true] {
            let single = TraceConfig {
                slope_diffraction,
                ..default.clone()
            };
            assert!(written(&single).get("slope_diffraction").is_none());
            assert_eq!(read(written(&single)), default);
        }
        // Two diffractions of a version that knew no slopes.
        let mut earlier = written(&TraceConfig::converged());
        let settings = earlier.as_object_mut().unwrap();
        assert_eq!(settings.remove("slope_diffraction"), Some(json!(true)));
        assert!(!read(earlier).slope_diffraction);
    }

    #[test]
    fn what_was_not_traced_has_no_tracing() {
        let imported = json!({ "import": "propbin", "sampling": { "rx_per_map": null } });
        assert_eq!(tracing_of(&imported).unwrap(), None);
        assert!(label_of(&imported).is_err());
    }
}
