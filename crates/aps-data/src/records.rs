//! The tracer's path records as the data set stores them and as a label sees them.

use aps_label::PathSample;
use aps_raytrace::PathRecord;

use crate::paths::{InteractionKind, PathTable};

impl From<aps_raytrace::InteractionKind> for InteractionKind {
    fn from(kind: aps_raytrace::InteractionKind) -> Self {
        match kind {
            aps_raytrace::InteractionKind::Reflection => InteractionKind::Reflection,
            aps_raytrace::InteractionKind::Diffraction => InteractionKind::Diffraction,
        }
    }
}

/// Returns the part of a traced path that a label sees.
pub fn sample_of(path: &PathRecord) -> PathSample {
    PathSample {
        delay_s: path.delay_s,
        arrival_azimuth_rad: path.arrival_azimuth_rad,
        gain_db: path.gain_db(),
    }
}

impl PathTable {
    /// Appends a link with its traced paths.
    pub fn push_records(&mut self, paths: &[PathRecord]) {
        for path in paths {
            self.delay_s.push(path.delay_s);
            self.departure_azimuth_rad.push(path.departure_azimuth_rad);
            self.arrival_azimuth_rad.push(path.arrival_azimuth_rad);
            self.gain.push([path.gain.re, path.gain.im]);
            for i in &path.interactions {
                self.interaction_kind.push(i.kind.into());
                self.interaction_id.push(i.id);
                self.interaction_point_m.push(i.point.to_array());
            }
            self.end_path();
        }
        self.end_link();
    }
}
