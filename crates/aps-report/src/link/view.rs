//! A link as people look at it, traced now or read from a file.

use aps_data::{InteractionKind, PathTable, UNKNOWN_ID};
use aps_label::PathSample;
use aps_raytrace::glam::DVec2;
use aps_raytrace::{PathRecord, SPEED_OF_LIGHT_M_PER_S};

/// A point where a path bends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bend {
    /// The event; [`InteractionKind::Other`] where the source of the path does not tell.
    pub kind: InteractionKind,
    /// Wall or corner, where it is known.
    pub id: Option<u32>,
    /// Its place \[m\].
    pub point: DVec2,
}

/// One path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathView {
    /// Its bends, from transmitter to receiver.
    pub bends: Vec<Bend>,
    /// Delay \[s\].
    pub delay_s: f64,
    /// Direction from the receiver towards the last bend \[rad\].
    pub arrival_azimuth_rad: f64,
    /// Power received over power sent \[dB\].
    pub gain_db: f64,
}

/// One link with all its paths.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkView {
    /// Transmitter \[m\].
    pub tx: DVec2,
    /// Receiver \[m\].
    pub rx: DVec2,
    /// Its paths.
    pub paths: Vec<PathView>,
}

/// Words for a title that say where angles are counted from; none at a heading of 0.
pub fn heading_words(heading_deg: f64) -> String {
    if heading_deg == 0.0 {
        return String::new();
    }
    format!(", angles from the array's heading {heading_deg} deg")
}

impl PathView {
    /// Unfolded length \[m\].
    pub fn length_m(&self) -> f64 {
        self.delay_s * SPEED_OF_LIGHT_M_PER_S
    }

    /// The part of the path that a label sees.
    pub fn sample(&self) -> PathSample {
        PathSample {
            delay_s: self.delay_s,
            arrival_azimuth_rad: self.arrival_azimuth_rad,
            gain_db: self.gain_db,
        }
    }

    /// `R12 D7`: reflection at wall 12, diffraction at corner 7; `LoS` (line of sight) for none.
    pub fn name(&self) -> String {
        if self.bends.is_empty() {
            return "LoS".into();
        }
        let name = |bend: &Bend| {
            let kind = match bend.kind {
                InteractionKind::Reflection => "R",
                InteractionKind::Diffraction => "D",
                InteractionKind::Other(_) => "?",
            };
            bend.id.map_or(kind.into(), |id: u32| format!("{kind}{id}"))
        };
        self.bends.iter().map(name).collect::<Vec<_>>().join(" ")
    }
}

impl From<&PathRecord> for PathView {
    fn from(p: &PathRecord) -> Self {
        let bend = |i: &aps_raytrace::Interaction| Bend {
            kind: i.kind.into(),
            id: Some(i.id),
            point: i.point,
        };
        Self {
            bends: p.interactions.iter().map(bend).collect(),
            delay_s: p.delay_s,
            arrival_azimuth_rad: p.arrival_azimuth_rad,
            gain_db: p.gain_db(),
        }
    }
}

impl LinkView {
    /// A link just traced.
    pub fn traced(tx: DVec2, rx: DVec2, paths: &[PathRecord]) -> Self {
        Self {
            tx,
            rx,
            paths: paths.iter().map(PathView::from).collect(),
        }
    }

    /// The link as an array turned by `heading_deg`, counter-clockwise, sees it: arrival azimuths counted from there.
    #[must_use]
    pub fn from_heading(mut self, heading_deg: f64) -> Self {
        for path in &mut self.paths {
            let seen = path.sample().from_heading(heading_deg.to_radians());
            path.arrival_azimuth_rad = seen.arrival_azimuth_rad;
        }
        self
    }

    /// A link as a data set stores it.
    ///
    /// # Panics
    /// When the table has no such link.
    pub fn stored([tx, rx]: [DVec2; 2], table: &PathTable, link: usize) -> Self {
        let bend = |i: usize| Bend {
            kind: table.interaction_kind[i],
            id: Some(table.interaction_id[i]).filter(|&id| id != UNKNOWN_ID),
            point: table.interaction_point_m[i].into(),
        };
        let path = |path: usize| {
            let sample = table.sample(path);
            PathView {
                bends: table.interactions_of(path).map(bend).collect(),
                delay_s: sample.delay_s,
                arrival_azimuth_rad: sample.arrival_azimuth_rad,
                gain_db: sample.gain_db,
            }
        };
        let paths = table.paths_of(link).map(path).collect();
        Self { tx, rx, paths }
    }

    /// The parts of the paths that a label sees, in their order.
    pub fn samples(&self) -> Vec<PathSample> {
        self.paths.iter().map(PathView::sample).collect()
    }

    /// Straight from end to end \[m\].
    pub fn distance_m(&self) -> f64 {
        self.tx.distance(self.rx)
    }

    /// Returns true if a path is direct.
    pub fn has_line_of_sight(&self) -> bool {
        self.paths.iter().any(|p| p.bends.is_empty())
    }

    /// Minus the gain of all paths together, their powers added \[dB\]; none without paths.
    pub fn path_loss_db(&self) -> Option<f64> {
        let power: f64 = self.paths.iter().map(|p| power(p.gain_db)).sum();
        (power > 0.0).then(|| -10.0 * power.log10())
    }

    /// Standard deviation of the delay, paths weighted by their power \[s\]; none without paths.
    pub fn delay_spread_s(&self) -> Option<f64> {
        let gains = self.paths.iter().map(|p| p.gain_db);
        let strongest = gains.fold(f64::NEG_INFINITY, f64::max);
        if !strongest.is_finite() {
            return None;
        }
        let weighted = || {
            let weight = |p: &PathView| (power(p.gain_db - strongest), p.delay_s);
            self.paths.iter().map(weight)
        };
        let total: f64 = weighted().map(|(w, _)| w).sum();
        let mean = weighted().map(|(w, t)| w * t).sum::<f64>() / total;
        let variance = weighted().map(|(w, t)| w * (t - mean).powi(2)).sum::<f64>() / total;
        Some(variance.sqrt())
    }
}

fn power(gain_db: f64) -> f64 {
    10_f64.powf(gain_db / 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(delay_s: f64, gain_db: f64) -> PathView {
        PathView {
            bends: Vec::new(),
            delay_s,
            arrival_azimuth_rad: 0.0,
            gain_db,
        }
    }

    #[test]
    fn two_equal_paths_spread_by_half_their_distance() {
        let link = LinkView {
            tx: DVec2::ZERO,
            rx: DVec2::new(3.0, 4.0),
            paths: vec![path(100e-9, -90.0), path(300e-9, -90.0)],
        };
        assert!((link.delay_spread_s().unwrap() - 100e-9).abs() < 1e-20);
        assert!((link.path_loss_db().unwrap() - (90.0 - 10.0 * 2_f64.log10())).abs() < 1e-12);
        assert_eq!((link.distance_m(), link.has_line_of_sight()), (5.0, true));
    }

    #[test]
    fn link_without_paths_has_no_spread_and_no_loss() {
        let link = LinkView {
            tx: DVec2::ZERO,
            rx: DVec2::ONE,
            paths: Vec::new(),
        };
        assert_eq!((link.delay_spread_s(), link.path_loss_db()), (None, None));
    }
}
