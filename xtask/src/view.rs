//! A link as people look at it: traced now or read from a data set, it is the same.

use aps_data::{PathTable, UNKNOWN_ID};
use aps_label::PathSample;
use aps_raytrace::glam::DVec2;
use aps_raytrace::{PathRecord, SPEED_OF_LIGHT_M_PER_S};

/// What happens where a path bends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BendKind {
    /// At a wall.
    Reflection,
    /// At a corner.
    Diffraction,
    /// Not told by whoever wrote the path.
    Unknown,
}

/// A point where a path bends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bend {
    pub kind: BendKind,
    /// Wall or corner, where it is known.
    pub id: Option<u32>,
    /// Where \[m\].
    pub point: DVec2,
}

/// One path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathView {
    /// From transmitter to receiver.
    pub bends: Vec<Bend>,
    pub delay_s: f64,
    /// From the receiver towards the last bend.
    pub arrival_azimuth_rad: f64,
    pub gain_db: f64,
}

/// One link with all its paths.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkView {
    /// Transmitter \[m\].
    pub tx: DVec2,
    /// Receiver \[m\].
    pub rx: DVec2,
    pub paths: Vec<PathView>,
}

impl PathView {
    /// Unfolded length \[m\].
    pub fn length_m(&self) -> f64 {
        self.delay_s * SPEED_OF_LIGHT_M_PER_S
    }

    /// What a label sees of the path.
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
                BendKind::Reflection => "R",
                BendKind::Diffraction => "D",
                BendKind::Unknown => "?",
            };
            bend.id.map_or(kind.into(), |id: u32| format!("{kind}{id}"))
        };
        self.bends.iter().map(name).collect::<Vec<_>>().join(" ")
    }

    /// The paths of a link as a data set stores them.
    pub fn stored(table: &PathTable, link: usize) -> Vec<Self> {
        let bend = |i: usize| Bend {
            kind: match table.interaction_kind[i] {
                aps_data::InteractionKind::Reflection => BendKind::Reflection,
                aps_data::InteractionKind::Diffraction => BendKind::Diffraction,
                aps_data::InteractionKind::Other(_) => BendKind::Unknown,
            },
            id: Some(table.interaction_id[i]).filter(|&id| id != UNKNOWN_ID),
            point: DVec2::from(table.interaction_point_m[i]),
        };
        let path = |p: usize| {
            let [re, im] = table.gain[p];
            Self {
                bends: table.interactions_of(p).map(bend).collect(),
                delay_s: table.delay_s[p],
                arrival_azimuth_rad: table.arrival_azimuth_rad[p],
                // As a fresh trace has it: a stored path gives the same label to the bit.
                gain_db: 10.0 * (re * re + im * im).log10(),
            }
        };
        table.paths_of(link).map(path).collect()
    }
}

impl From<&PathRecord> for PathView {
    fn from(p: &PathRecord) -> Self {
        let bend = |i: &aps_raytrace::Interaction| Bend {
            kind: match i.kind {
                aps_raytrace::InteractionKind::Reflection => BendKind::Reflection,
                aps_raytrace::InteractionKind::Diffraction => BendKind::Diffraction,
            },
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

    /// What a label sees of the paths, in their order.
    pub fn samples(&self) -> Vec<PathSample> {
        self.paths.iter().map(PathView::sample).collect()
    }

    /// Straight from end to end \[m\].
    pub fn distance_m(&self) -> f64 {
        self.tx.distance(self.rx)
    }

    /// Whether a path goes straight.
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
        let strongest = self
            .paths
            .iter()
            .map(|p| p.gain_db)
            .fold(f64::NEG_INFINITY, f64::max);
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
