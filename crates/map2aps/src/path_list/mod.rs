//! Lists of links and their paths as JSON.

mod error;
#[cfg(test)]
mod fuzz;

use std::io::Read;

use aps_data::InteractionKind;
use aps_label::{Labeler, PathSample};
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Interaction, PathRecord};
use serde::{Deserialize, Serialize};

use crate::error::{At, Place, Result};

pub use error::PathListError;

/// A list of links with their paths.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct LinkList {
    /// The links.
    pub links: Vec<LinkEntry>,
}

/// One link. Labels need only the paths.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LinkEntry {
    /// Transmitter \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tx: Option<[f64; 2]>,
    /// Receiver \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rx: Option<[f64; 2]>,
    /// Its paths.
    pub paths: Vec<PathEntry>,
}

/// One path. Labels need delay, arrival azimuth and gain only.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PathEntry {
    /// Interactions in the order from transmitter to receiver.
    #[serde(default)]
    pub interactions: Vec<InteractionEntry>,
    /// Length \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
    /// Delay \[s\].
    pub delay_s: f64,
    /// Direction from the transmitter to the first interaction \[rad\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub departure_azimuth_rad: Option<f64>,
    /// Direction from the receiver towards the last interaction, counter-clockwise from +x \[rad\].
    pub arrival_azimuth_rad: f64,
    /// Minus the path loss \[dB\].
    pub gain_db: f64,
}

/// One interaction: a reflection at a wall or a diffraction at a corner.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct InteractionEntry {
    /// Kind of the interaction.
    pub kind: InteractionKind,
    /// Wall of a reflection.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall: Option<u32>,
    /// Corner of a diffraction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner: Option<u32>,
    /// Place of the interaction \[m\].
    pub point: [f64; 2],
}

impl LinkList {
    /// Reads a list, with or without a byte order mark.
    ///
    /// # Errors
    /// [`PathListError::Io`], [`PathListError::Form`] and [`PathListError::MoreText`].
    pub fn read(mut reader: impl Read) -> Result<Self, PathListError> {
        const MARK: &[u8] = b"\xef\xbb\xbf";
        let mut start = Vec::new();
        let read = reader
            .by_ref()
            .take(MARK.len() as u64)
            .read_to_end(&mut start);
        read?;
        let start = start.strip_prefix(MARK).unwrap_or(&start);
        let mut json = serde_json::Deserializer::from_reader(start.chain(reader));
        let list = serde_path_to_error::deserialize(&mut json);
        let list = list.map_err(|error| match error.inner().is_io() {
            true => PathListError::Io(error.into_inner().into()),
            false => PathListError::Form(error.to_string()),
        })?;
        json.end().map_err(|error| match error.is_io() {
            true => PathListError::Io(error.into()),
            false => PathListError::MoreText(error),
        })?;
        Ok(list)
    }

    /// Labels every link.
    ///
    /// # Errors
    /// Paths that cannot be labelled, by link, and [`PathListError::NoLabel`].
    pub fn label(&self, labeler: &Labeler) -> Result<ListLabels> {
        let mut labels = ListLabels::default();
        let mut without = Vec::new();
        for (i, link) in self.links.iter().enumerate() {
            let paths = link.paths.iter().enumerate();
            let sample = |(k, path): (usize, &PathEntry)| path.sample().at(Place::Path(k));
            let samples: Result<Vec<PathSample>> = paths.map(sample).collect();
            let label = labeler.label(&samples.at(Place::Link(i))?);
            match label.at(Place::Link(i))? {
                Some(label) => {
                    labels.aps_db.extend(label.aps_db);
                    labels.pdp_db.extend(label.pdp_db);
                }
                None => without.push(i),
            }
        }
        match without.is_empty() {
            true => Ok(labels),
            false => Err(PathListError::NoLabel {
                links: without,
                protocol: labeler.config().protocol,
            }
            .into()),
        }
    }
}

/// Labels of the links of a list, row by row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ListLabels {
    /// Angle power spectra \[dB\], of shape (links, bins).
    pub aps_db: Vec<f64>,
    /// Power delay profiles \[dB\], of shape (links, delays), if the labeler makes them.
    pub pdp_db: Vec<f64>,
}

impl LinkEntry {
    /// The entry of a traced link.
    pub fn new(tx: DVec2, rx: DVec2, paths: &[PathRecord]) -> Self {
        Self {
            tx: Some(tx.to_array()),
            rx: Some(rx.to_array()),
            paths: paths.iter().map(PathEntry::from).collect(),
        }
    }
}

/// Largest azimuth that others' programs give \[rad\]: a turn, and what half precision may add to it. For labels alone
/// any number of turns would do, but 135 of them are degrees.
const MAX_AZIMUTH_RAD: f64 = std::f64::consts::TAU + 0.01;

/// Refuses an azimuth that must be meant in degrees. One that is no number passes, for labels refuse it.
pub(crate) fn check_azimuth(field: &'static str, azimuth_rad: f64) -> Result<(), PathListError> {
    match azimuth_rad.abs() > MAX_AZIMUTH_RAD {
        true => Err(PathListError::Azimuth { field, azimuth_rad }),
        false => Ok(()),
    }
}

impl PathEntry {
    /// The part of the path that a label sees.
    ///
    /// # Errors
    /// [`PathListError::Azimuth`].
    pub fn sample(&self) -> Result<PathSample, PathListError> {
        check_azimuth("arrival_azimuth_rad", self.arrival_azimuth_rad)?;
        Ok(PathSample {
            delay_s: self.delay_s,
            arrival_azimuth_rad: self.arrival_azimuth_rad,
            gain_db: self.gain_db,
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_order_mark_is_passed_over() {
        let text = r#"{ "links": [{ "paths": [] }] }"#;
        let read = |text: String| LinkList::read(text.as_bytes());
        assert_eq!(read(format!("\u{feff}{text}")).unwrap().links.len(), 1);
        assert!(read(format!("\u{feff}\u{feff}{text}")).is_err());
    }
}
