//! Propagation paths of links: ragged lists, stored as flat columns with offsets.
//!
//! Numbers are stored in full, so that a label made from stored paths is the label a fresh trace
//! would get.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::status::LinkStatus;

/// Stored as the id of an interaction when wall or corner is not known.
pub const UNKNOWN_ID: u32 = u32::MAX;

/// Kind of an interaction, at which a path bends: stored as one byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InteractionKind {
    /// Code 0: specular reflection at a wall.
    Reflection,
    /// Code 1: diffraction at a corner.
    Diffraction,
    /// A code this version does not know; 255 for imported points of unknown kind.
    Other(u8),
}

impl InteractionKind {
    /// Returns the byte stored in `interaction_kind.npy`.
    pub fn code(self) -> u8 {
        match self {
            InteractionKind::Reflection => 0,
            InteractionKind::Diffraction => 1,
            InteractionKind::Other(code) => code,
        }
    }

    /// Returns the kind with the given code.
    pub fn from_code(code: u8) -> Self {
        match code {
            0 => InteractionKind::Reflection,
            1 => InteractionKind::Diffraction,
            code => InteractionKind::Other(code),
        }
    }
}

/// The paths of some links to be written, flat: those of the first link first, and within a path
/// its interactions in the order from transmitter to receiver.
#[derive(Debug, Clone, Copy, Default)]
pub struct PathRows<'a> {
    /// Number of paths of each link.
    pub paths_per_link: &'a [usize],
    /// Delay of each path \[s\].
    pub delay_s: &'a [f64],
    /// Azimuth from the transmitter to the first interaction, or to the receiver \[rad\].
    pub departure_azimuth_rad: &'a [f64],
    /// Azimuth from the receiver to the last interaction, or to the transmitter \[rad\].
    pub arrival_azimuth_rad: &'a [f64],
    /// Complex amplitude `[re, im]` relative to isotropic antennas; power gain is its squared
    /// magnitude.
    pub gain: &'a [[f64; 2]],
    /// Number of interactions of each path.
    pub interactions_per_path: &'a [usize],
    /// Kind of each interaction.
    pub interaction_kind: &'a [InteractionKind],
    /// Number of each interaction's wall or corner in the map, or [`UNKNOWN_ID`].
    pub interaction_id: &'a [u32],
    /// Position of each interaction \[m\].
    pub interaction_point_m: &'a [[f64; 2]],
}

impl PathRows<'_> {
    /// Describes a fault of the rows; `None` if they are sound. `status` holds the states of the
    /// links, of which the first is link number `first`.
    pub(crate) fn problem(&self, status: &[LinkStatus], first: usize) -> Option<String> {
        let paths = self.delay_s.len();
        let interactions = self.interaction_kind.len();
        let columns = [
            ("paths_per_link", self.paths_per_link.len(), status.len()),
            (
                "departure_azimuth_rad",
                self.departure_azimuth_rad.len(),
                paths,
            ),
            ("arrival_azimuth_rad", self.arrival_azimuth_rad.len(), paths),
            ("gain", self.gain.len(), paths),
            (
                "interactions_per_path",
                self.interactions_per_path.len(),
                paths,
            ),
            ("interaction_id", self.interaction_id.len(), interactions),
            (
                "interaction_point_m",
                self.interaction_point_m.len(),
                interactions,
            ),
            ("delay_s", paths, sum_of(self.paths_per_link)),
            (
                "interaction_kind",
                interactions,
                sum_of(self.interactions_per_path),
            ),
        ];
        if let Some((name, found, wanted)) = columns
            .into_iter()
            .find(|(_, found, wanted)| found != wanted)
        {
            return Some(format!("{name} has {found} values, expected {wanted}"));
        }
        for (i, (status, &paths)) in status.iter().zip(self.paths_per_link).enumerate() {
            if !may_have_paths(*status, paths) {
                return Some(format!(
                    "link {} is {status}, but has {paths} paths",
                    first + i
                ));
            }
        }
        let out_of_range = out_of_range(
            self.delay_s,
            self.departure_azimuth_rad,
            self.arrival_azimuth_rad,
        );
        if out_of_range.is_some() {
            return out_of_range;
        }
        first_not_finite([
            ("delay_s", self.delay_s),
            ("departure_azimuth_rad", self.departure_azimuth_rad),
            ("arrival_azimuth_rad", self.arrival_azimuth_rad),
            ("gain", self.gain.as_flattened()),
            (
                "interaction_point_m",
                self.interaction_point_m.as_flattened(),
            ),
        ])
    }
}

/// Sums the counts; a sum that does not fit becomes `usize::MAX`, which no column is long enough for.
fn sum_of(counts: &[usize]) -> usize {
    counts
        .iter()
        .fold(0, |sum: usize, &n| sum.saturating_add(n))
}

/// Returns true when a link of this state may have so many paths: a labelled link has a path; only a
/// labelled one or one whose paths were all dropped has any.
fn may_have_paths(status: LinkStatus, paths: usize) -> bool {
    match status {
        LinkStatus::Valid => paths > 0,
        LinkStatus::Unlabelled | LinkStatus::Other(_) => true,
        _ => paths == 0,
    }
}

/// Describes the first delay below zero or azimuth beyond a full turn.
fn out_of_range(delay_s: &[f64], departure_rad: &[f64], arrival_rad: &[f64]) -> Option<String> {
    if let Some(bad) = delay_s.iter().position(|&x| x < 0.0) {
        return Some(format!("delay_s number {bad} is {}, below 0", delay_s[bad]));
    }
    let azimuths = [
        ("departure_azimuth_rad", departure_rad),
        ("arrival_azimuth_rad", arrival_rad),
    ];
    azimuths.into_iter().find_map(|(name, values)| {
        let bad = values.iter().position(|x| x.abs() > TAU)?;
        let value = values[bad];
        Some(format!(
            "{name} number {bad} is {value}, beyond a full turn"
        ))
    })
}

fn first_not_finite<const N: usize>(columns: [(&str, &[f64]); N]) -> Option<String> {
    columns.into_iter().find_map(|(name, values)| {
        let bad = values.iter().position(|value| !value.is_finite())?;
        Some(format!("{name} number {bad} is {}", values[bad]))
    })
}

/// The paths of all links of a map, as stored.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PathTable {
    pub(crate) path_offset: Vec<u64>,
    /// Delay of each path \[s\].
    pub delay_s: Vec<f64>,
    /// Azimuth from the transmitter to the first interaction, or to the receiver \[rad\].
    pub departure_azimuth_rad: Vec<f64>,
    /// Azimuth from the receiver to the last interaction, or to the transmitter \[rad\].
    pub arrival_azimuth_rad: Vec<f64>,
    /// Complex amplitude `[re, im]` relative to isotropic antennas.
    pub gain: Vec<[f64; 2]>,
    pub(crate) interaction_offset: Vec<u64>,
    /// Kind of each interaction.
    pub interaction_kind: Vec<InteractionKind>,
    /// Number of each interaction's wall or corner in the map, or [`UNKNOWN_ID`].
    pub interaction_id: Vec<u32>,
    /// Position of each interaction \[m\].
    pub interaction_point_m: Vec<[f64; 2]>,
}

impl PathTable {
    /// Returns the paths of a link: indices into `delay_s` and the other columns of paths.
    ///
    /// # Panics
    /// When there is no such link.
    pub fn paths_of(&self, link: usize) -> Range<usize> {
        self.path_offset[link] as usize..self.path_offset[link + 1] as usize
    }

    /// Returns the interactions of a path: indices into `interaction_kind` and the other columns of
    /// interactions.
    ///
    /// # Panics
    /// When there is no such path.
    pub fn interactions_of(&self, path: usize) -> Range<usize> {
        self.interaction_offset[path] as usize..self.interaction_offset[path + 1] as usize
    }

    /// Describes a contradiction to the states of the links; `None` if there is none, and then no
    /// range leads outside its columns.
    pub(crate) fn problem(&self, status: &[LinkStatus]) -> Option<String> {
        let is_sound = |offset: &[u64], rows: usize| {
            offset.first() == Some(&0)
                && offset.is_sorted()
                && offset.last() == Some(&(rows as u64))
        };
        if !is_sound(&self.path_offset, self.delay_s.len()) {
            return Some("path_offset does not rise from 0 to the number of paths".into());
        }
        if !is_sound(&self.interaction_offset, self.interaction_kind.len()) {
            return Some(
                "interaction_offset does not rise from 0 to the number of interactions".into(),
            );
        }
        for (link, status) in status.iter().enumerate() {
            let paths = self.paths_of(link).len();
            if !may_have_paths(*status, paths) {
                return Some(format!("link {link} is {status}, but has {paths} paths"));
            }
        }
        out_of_range(
            &self.delay_s,
            &self.departure_azimuth_rad,
            &self.arrival_azimuth_rad,
        )
        .or_else(|| self.not_finite())
    }

    fn not_finite(&self) -> Option<String> {
        first_not_finite([
            ("delay_s", &self.delay_s),
            ("departure_azimuth_rad", &self.departure_azimuth_rad),
            ("arrival_azimuth_rad", &self.arrival_azimuth_rad),
            ("gain", self.gain.as_flattened()),
            (
                "interaction_point_m",
                self.interaction_point_m.as_flattened(),
            ),
        ])
    }
}
