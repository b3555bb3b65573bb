//! Propagation paths of links: ragged lists, stored as flat columns with offsets.
//!
//! Numbers are stored in full, so that a label made from stored paths is the label a fresh trace
//! would get.

use std::f64::consts::TAU;
use std::ops::Range;

use aps_label::PathSample;
use serde::{Deserialize, Serialize};

use crate::status::LinkStatus;

/// Stored as the id of an interaction when wall or corner is not known.
pub const UNKNOWN_ID: u32 = u32::MAX;

/// Kind of an interaction, at which a path bends: stored as one byte, in JSON `reflection` or `diffraction`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InteractionKind {
    /// Code 0: specular reflection at a wall.
    Reflection,
    /// Code 1: diffraction at a corner.
    Diffraction,
    /// A code this version does not know; 255 for imported points of unknown kind. Has no name in JSON.
    #[serde(skip)]
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

/// Paths of links: flat columns, those of the first link first, and within a path its interactions from transmitter to
/// receiver.
///
/// To append, push the values of interactions and paths to their columns and close each path by
/// [`PathTable::end_path`], each link by [`PathTable::end_link`]. Columns that do not fit each other are refused when they
/// are written.
#[derive(Debug, Clone, PartialEq)]
pub struct PathTable {
    pub(crate) path_offset: Vec<u64>,
    /// Delay of each path \[s\].
    pub delay_s: Vec<f64>,
    /// Azimuth from the transmitter to the first interaction, or to the receiver \[rad\].
    pub departure_azimuth_rad: Vec<f64>,
    /// Azimuth from the receiver to the last interaction, or to the transmitter \[rad\].
    pub arrival_azimuth_rad: Vec<f64>,
    /// Complex amplitude `[re, im]` relative to isotropic antennas; power gain is its squared magnitude.
    pub gain: Vec<[f64; 2]>,
    pub(crate) interaction_offset: Vec<u64>,
    /// Kind of each interaction.
    pub interaction_kind: Vec<InteractionKind>,
    /// Number of each interaction's wall or corner in the map, or [`UNKNOWN_ID`].
    pub interaction_id: Vec<u32>,
    /// Position of each interaction \[m\].
    pub interaction_point_m: Vec<[f64; 2]>,
}

impl Default for PathTable {
    /// A table without links.
    fn default() -> Self {
        PathTable {
            path_offset: vec![0],
            delay_s: Vec::new(),
            departure_azimuth_rad: Vec::new(),
            arrival_azimuth_rad: Vec::new(),
            gain: Vec::new(),
            interaction_offset: vec![0],
            interaction_kind: Vec::new(),
            interaction_id: Vec::new(),
            interaction_point_m: Vec::new(),
        }
    }
}

impl PathTable {
    /// Returns the number of links.
    pub fn links(&self) -> usize {
        self.path_offset.len() - 1
    }

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

    /// Returns the part of a path that a label sees: the same bits as from the traced path that was stored.
    ///
    /// # Panics
    /// When there is no such path.
    pub fn sample(&self, path: usize) -> PathSample {
        let [re, im] = self.gain[path];
        PathSample {
            delay_s: self.delay_s[path],
            arrival_azimuth_rad: self.arrival_azimuth_rad[path],
            gain_db: 10.0 * (re * re + im * im).log10(),
        }
    }

    /// Gives the interactions pushed since the path before to the path pushed last.
    pub fn end_path(&mut self) {
        let end = self.interaction_kind.len() as u64;
        self.interaction_offset.push(end);
    }

    /// Gives the paths pushed since the link before to the next link.
    pub fn end_link(&mut self) {
        self.path_offset.push(self.delay_s.len() as u64);
    }

    /// Appends a link of another table.
    ///
    /// # Panics
    /// When there is no such link.
    pub fn push_link(&mut self, other: &PathTable, link: usize) {
        let paths = other.paths_of(link);
        let offset = &other.interaction_offset[paths.start..=paths.end];
        let interactions = offset[0] as usize..offset[paths.len()] as usize;
        let base = self.interaction_kind.len() as u64;
        let moved = offset[1..].iter().map(|end| end - offset[0] + base);
        self.interaction_offset.extend(moved);
        for (own, other) in [
            (&mut self.delay_s, &other.delay_s),
            (
                &mut self.departure_azimuth_rad,
                &other.departure_azimuth_rad,
            ),
            (&mut self.arrival_azimuth_rad, &other.arrival_azimuth_rad),
        ] {
            own.extend_from_slice(&other[paths.clone()]);
        }
        self.gain.extend_from_slice(&other.gain[paths]);
        let kinds = &other.interaction_kind[interactions.clone()];
        self.interaction_kind.extend_from_slice(kinds);
        let ids = &other.interaction_id[interactions.clone()];
        self.interaction_id.extend_from_slice(ids);
        let points = &other.interaction_point_m[interactions];
        self.interaction_point_m.extend_from_slice(points);
        self.end_link();
    }

    /// Appends all links of another table.
    pub fn push_table(&mut self, other: &PathTable) {
        (0..other.links()).for_each(|link| self.push_link(other, link));
    }

    /// Returns a table of some links, in the order in which they are given.
    ///
    /// # Panics
    /// When there is no such link.
    pub fn of_links(&self, links: impl IntoIterator<Item = usize>) -> Self {
        let mut table = PathTable::default();
        let links = links.into_iter();
        links.for_each(|link| table.push_link(self, link));
        table
    }

    /// Returns true when every number has the same bits.
    pub fn is_same(&self, other: &PathTable) -> bool {
        let bits = |table: &PathTable| -> Vec<u64> {
            let numbers = table.numbers().into_iter().flat_map(|(_, values)| values);
            numbers.map(|value| value.to_bits()).collect()
        };
        self.path_offset == other.path_offset
            && self.interaction_offset == other.interaction_offset
            && self.interaction_kind == other.interaction_kind
            && self.interaction_id == other.interaction_id
            && bits(self) == bits(other)
    }

    /// The columns of real numbers, by name.
    fn numbers(&self) -> [(&'static str, &[f64]); 5] {
        [
            ("delay_s", &self.delay_s),
            ("departure_azimuth_rad", &self.departure_azimuth_rad),
            ("arrival_azimuth_rad", &self.arrival_azimuth_rad),
            ("gain", self.gain.as_flattened()),
            (
                "interaction_point_m",
                self.interaction_point_m.as_flattened(),
            ),
        ]
    }

    /// Describes a fault, or a contradiction to the states of the links, of which the first is link number `first`;
    /// `None` if there is none, and then no range leads outside its columns.
    pub(crate) fn problem(&self, status: &[LinkStatus], first: usize) -> Option<String> {
        let (paths, interactions) = (self.delay_s.len(), self.interaction_kind.len());
        let columns = [
            ("path_offset", self.path_offset.len(), status.len() + 1),
            (
                "departure_azimuth_rad",
                self.departure_azimuth_rad.len(),
                paths,
            ),
            ("arrival_azimuth_rad", self.arrival_azimuth_rad.len(), paths),
            ("gain", self.gain.len(), paths),
            (
                "interaction_offset",
                self.interaction_offset.len(),
                paths + 1,
            ),
            ("interaction_id", self.interaction_id.len(), interactions),
            (
                "interaction_point_m",
                self.interaction_point_m.len(),
                interactions,
            ),
        ];
        let misfit = columns
            .into_iter()
            .find(|(_, found, wanted)| found != wanted);
        if let Some((name, found, wanted)) = misfit {
            return Some(format!("{name} has {found} values, expected {wanted}"));
        }
        let offsets = [
            ("path_offset", &self.path_offset, paths, "paths"),
            (
                "interaction_offset",
                &self.interaction_offset,
                interactions,
                "interactions",
            ),
        ];
        for (name, offset, rows, of) in offsets {
            let ends = (offset.first(), offset.last());
            if ends != (Some(&0), Some(&(rows as u64))) || !offset.is_sorted() {
                return Some(format!("{name} does not rise from 0 to the number of {of}"));
            }
        }
        for (link, status) in status.iter().enumerate() {
            let paths = self.paths_of(link).len();
            if !may_have_paths(*status, paths) {
                let link = first + link;
                return Some(format!("link {link} is {status}, but has {paths} paths"));
            }
        }
        if let Some(bad) = self.delay_s.iter().position(|&x| x < 0.0) {
            let delay_s = self.delay_s[bad];
            return Some(format!("delay_s number {bad} is {delay_s}, below 0"));
        }
        let numbers = self.numbers();
        let fault = |(name, values): (&str, &[f64]), test: fn(f64) -> bool, words: &str| {
            let bad = values.iter().position(|&value| test(value))?;
            Some(format!("{name} number {bad} is {}{words}", values[bad]))
        };
        let turns = numbers[1..3].iter().copied();
        turns
            .map(|column| fault(column, |x| x.abs() > TAU, ", beyond a full turn"))
            .chain(
                numbers
                    .into_iter()
                    .map(|column| fault(column, |x| !x.is_finite(), "")),
            )
            .find_map(|fault| fault)
    }
}

/// Returns true when a link of this state may have so many paths: a labelled link has a path; only a
/// labelled one or one whose paths were all dropped has any.
fn may_have_paths(status: LinkStatus, paths: usize) -> bool {
    match status {
        LinkStatus::Valid => paths > 0,
        LinkStatus::Unlabelled | LinkStatus::Other(_) => true,
        LinkStatus::NoPath
        | LinkStatus::TxInBuilding
        | LinkStatus::RxInBuilding
        | LinkStatus::OutsideArea
        | LinkStatus::SamePoint
        | LinkStatus::OnWall
        | LinkStatus::Enclosed => paths == 0,
    }
}
