//! The settings of a data set as its manifest keeps them, and read back.
//!
//! Everything a link depends on is there: `maps` (their kind), `scene`, `sampling`, `trace`, `label`, and the seed beside them. So
//! a stored data set can be labelled anew, and its links computed again and compared.

use anyhow::{Context, Result, bail};
use aps_label::LabelConfig;
use aps_raytrace::{Material, TraceConfig};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::maps::SceneSettings;
use crate::sampling::Sampling;

/// The `configuration` of a traced data set; `maps` says what kind they are of.
pub fn of_traced(
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

/// The label settings in a `configuration`.
pub fn label_of(configuration: &Value) -> Result<LabelConfig> {
    let label = configuration.get("label");
    let label = label.context("its manifest has no label settings")?;
    serde_json::from_value(label.clone()).context("its manifest has unknown label settings")
}

/// Reads the settings of terminals and trace in a `configuration`; `None` if the data set was not traced here.
pub fn tracing_of(configuration: &Value) -> Result<Option<(Sampling, TraceConfig)>> {
    let (Some(trace), Some(sampling)) = (configuration.get("trace"), configuration.get("sampling"))
    else {
        return Ok(None);
    };
    let trace: TraceSettings =
        serde_json::from_value(trace.clone()).context("its manifest has unknown trace settings")?;
    let sampling = serde_json::from_value(sampling.clone())
        .context("its manifest has unknown sampling settings")?;
    Ok(Some((sampling, trace.config()?)))
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
            dynamic_range_db: config.dynamic_range_db,
            accuracy_db: None,
            max_fallback_diffractions: config.max_fallback_diffractions,
        }
    }

    fn config(self) -> Result<TraceConfig> {
        if let Some(accuracy_db) = self.accuracy_db {
            bail!(
                "it was traced with --accuracy {accuracy_db}, which is gone: its links cannot be computed anew"
            );
        }
        let material = match self.material {
            MaterialSetting::Named(name) => match name.as_str() {
                "concrete" => Material::Concrete,
                "pec" => Material::PerfectConductor,
                _ => bail!("its manifest names the unknown material '{name}'"),
            },
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
        let materials = [
            Material::Concrete,
            Material::PerfectConductor,
            Material::Dielectric {
                relative_permittivity: 6.1,
                conductivity_s_per_m: 0.03,
            },
        ];
        for material in materials {
            let trace = TraceConfig {
                material,
                dynamic_range_db: None,
                frequency_hz: 0.1 + 28e9,
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
            assert_eq!(tracing_of(&read).unwrap(), Some((sampling, trace)));
            assert_eq!(label_of(&read).unwrap(), label);
        }
    }

    #[test]
    fn what_was_not_traced_has_no_tracing() {
        let imported = json!({ "import": "propbin", "sampling": { "rx_per_map": null } });
        assert_eq!(tracing_of(&imported).unwrap(), None);
        assert!(label_of(&imported).is_err());
    }
}
