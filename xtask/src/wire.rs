//! Paths as JSON, which `trace` writes and `label` reads.

use std::io::Read;

use anyhow::{Context, Result, anyhow};
use aps_data::InteractionKind;
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Interaction, PathRecord};
use serde::{Deserialize, Serialize};

#[cfg(test)]
mod fuzz;

/// A list of links with their paths.
#[derive(Debug, Serialize, Deserialize)]
pub struct LinkList {
    pub links: Vec<LinkEntry>,
}

/// One link. `label` needs only the paths.
#[derive(Debug, Serialize, Deserialize)]
pub struct LinkEntry {
    /// Transmitter [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tx: Option<[f64; 2]>,
    /// Receiver [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rx: Option<[f64; 2]>,
    pub paths: Vec<PathEntry>,
}

/// One path. `label` needs delay, arrival azimuth and gain only.
#[derive(Debug, Serialize, Deserialize)]
pub struct PathEntry {
    #[serde(default)]
    pub interactions: Vec<InteractionEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
    pub delay_s: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub departure_azimuth_rad: Option<f64>,
    /// From the receiver towards the last interaction, counter-clockwise from +x.
    pub arrival_azimuth_rad: f64,
    /// Minus the path loss.
    pub gain_db: f64,
}

/// One interaction: a reflection at a wall or a diffraction at a corner.
#[derive(Debug, Serialize, Deserialize)]
pub struct InteractionEntry {
    pub kind: InteractionKind,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner: Option<u32>,
    pub point: [f64; 2],
}

impl LinkList {
    /// Reads a list.
    ///
    /// # Errors
    /// Text of another form; the error names the link, the path and the field.
    pub fn read(reader: impl Read) -> Result<Self> {
        let mut json = serde_json::Deserializer::from_reader(reader);
        let list = serde_path_to_error::deserialize(&mut json).map_err(|error| {
            anyhow!(
                "{error}; expected {{\"links\": [{{\"paths\": [{{\"delay_s\": 2e-7, \"arrival_azimuth_rad\": 0.5, \
                 \"gain_db\": -90}}]}}]}}, all numbers finite: leave out a path that has no gain, as NaN, null and \
                 -Infinity say"
            )
        })?;
        json.end()
            .context("more text follows the list; give one list a file")?;
        Ok(list)
    }
}

impl LinkEntry {
    pub fn new(tx: DVec2, rx: DVec2, paths: &[PathRecord]) -> Self {
        Self {
            tx: Some(tx.to_array()),
            rx: Some(rx.to_array()),
            paths: paths.iter().map(PathEntry::from).collect(),
        }
    }
}

impl From<&PathRecord> for PathEntry {
    fn from(p: &PathRecord) -> Self {
        Self {
            interactions: p.interactions.iter().map(InteractionEntry::from).collect(),
            length_m: Some(p.length_m),
            delay_s: p.delay_s,
            departure_azimuth_rad: Some(p.departure_azimuth_rad),
            arrival_azimuth_rad: p.arrival_azimuth_rad,
            gain_db: p.gain_db(),
        }
    }
}

impl From<&Interaction> for InteractionEntry {
    fn from(i: &Interaction) -> Self {
        let (wall, corner) = match i.kind {
            aps_raytrace::InteractionKind::Reflection => (Some(i.id), None),
            aps_raytrace::InteractionKind::Diffraction => (None, Some(i.id)),
        };
        Self {
            kind: i.kind.into(),
            wall,
            corner,
            point: i.point.to_array(),
        }
    }
}
