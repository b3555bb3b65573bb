//! Path records as the flat columns that a data set stores.

use aps_data::{InteractionKind, PathRows, PathTable};
use aps_raytrace::PathRecord;

/// Paths of consecutive links, column by column as [`PathRows`] has them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PathColumns {
    /// Number of paths of each link.
    pub paths_per_link: Vec<usize>,
    /// Delay of each path \[s\].
    pub delay_s: Vec<f64>,
    /// Direction from the transmitter \[rad\].
    pub departure_azimuth_rad: Vec<f64>,
    /// Direction from the receiver towards the source \[rad\].
    pub arrival_azimuth_rad: Vec<f64>,
    /// Complex amplitude `[re, im]`.
    pub gain: Vec<[f64; 2]>,
    /// Number of interactions of each path.
    pub interactions_per_path: Vec<usize>,
    /// Kind of each interaction.
    pub interaction_kind: Vec<InteractionKind>,
    /// Wall or corner of each interaction, or [`aps_data::UNKNOWN_ID`].
    pub interaction_id: Vec<u32>,
    /// Place of each interaction \[m\].
    pub interaction_point_m: Vec<[f64; 2]>,
}

impl PathColumns {
    /// Appends one link.
    pub(crate) fn push(&mut self, paths: &[PathRecord]) {
        self.paths_per_link.push(paths.len());
        for path in paths {
            self.delay_s.push(path.delay_s);
            self.departure_azimuth_rad.push(path.departure_azimuth_rad);
            self.arrival_azimuth_rad.push(path.arrival_azimuth_rad);
            self.gain.push([path.gain.re, path.gain.im]);
            self.interactions_per_path.push(path.interactions.len());
            for i in &path.interactions {
                self.interaction_kind.push(kind(i.kind));
                self.interaction_id.push(i.id);
                self.interaction_point_m.push(i.point.to_array());
            }
        }
    }

    /// Appends a stored link as it is.
    pub(crate) fn push_stored(&mut self, table: &PathTable, link: usize) {
        let paths = table.paths_of(link);
        self.paths_per_link.push(paths.len());
        for path in paths {
            self.delay_s.push(table.delay_s[path]);
            self.departure_azimuth_rad
                .push(table.departure_azimuth_rad[path]);
            self.arrival_azimuth_rad
                .push(table.arrival_azimuth_rad[path]);
            self.gain.push(table.gain[path]);
            let interactions = table.interactions_of(path);
            self.interactions_per_path.push(interactions.len());
            for i in interactions {
                self.interaction_kind.push(table.interaction_kind[i]);
                self.interaction_id.push(table.interaction_id[i]);
                self.interaction_point_m.push(table.interaction_point_m[i]);
            }
        }
    }

    /// Appends the links that follow.
    pub(crate) fn append(&mut self, mut other: Self) {
        self.paths_per_link.append(&mut other.paths_per_link);
        self.delay_s.append(&mut other.delay_s);
        self.departure_azimuth_rad
            .append(&mut other.departure_azimuth_rad);
        self.arrival_azimuth_rad
            .append(&mut other.arrival_azimuth_rad);
        self.gain.append(&mut other.gain);
        self.interactions_per_path
            .append(&mut other.interactions_per_path);
        self.interaction_kind.append(&mut other.interaction_kind);
        self.interaction_id.append(&mut other.interaction_id);
        self.interaction_point_m
            .append(&mut other.interaction_point_m);
    }

    /// Returns true when every number has the same bits.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        let bits = |columns: &Self| -> Vec<u64> {
            let values = columns
                .delay_s
                .iter()
                .chain(&columns.departure_azimuth_rad)
                .chain(&columns.arrival_azimuth_rad)
                .chain(columns.gain.as_flattened())
                .chain(columns.interaction_point_m.as_flattened());
            values.map(|value| value.to_bits()).collect()
        };
        self.paths_per_link == other.paths_per_link
            && self.interactions_per_path == other.interactions_per_path
            && self.interaction_kind == other.interaction_kind
            && self.interaction_id == other.interaction_id
            && bits(self) == bits(other)
    }

    /// The columns, borrowed.
    pub(crate) fn rows(&self) -> PathRows<'_> {
        PathRows {
            paths_per_link: &self.paths_per_link,
            delay_s: &self.delay_s,
            departure_azimuth_rad: &self.departure_azimuth_rad,
            arrival_azimuth_rad: &self.arrival_azimuth_rad,
            gain: &self.gain,
            interactions_per_path: &self.interactions_per_path,
            interaction_kind: &self.interaction_kind,
            interaction_id: &self.interaction_id,
            interaction_point_m: &self.interaction_point_m,
        }
    }
}

fn kind(kind: aps_raytrace::InteractionKind) -> InteractionKind {
    match kind {
        aps_raytrace::InteractionKind::Reflection => InteractionKind::Reflection,
        aps_raytrace::InteractionKind::Diffraction => InteractionKind::Diffraction,
    }
}
