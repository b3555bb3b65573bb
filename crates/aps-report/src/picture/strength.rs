//! Colours for gains: the stronger the path, the further it stands out.

use svg::node::element::Group;

use crate::drawing::{anchored, rectangle};
use crate::link::PathView;
use crate::theme::{Colour, STRENGTH_STEPS};

/// Weaker paths are drawn like this far below the strongest \[dB\].
const RANGE_DB: f64 = 60.0;

/// Range of gains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainScale {
    weakest_db: f64,
    strongest_db: f64,
}

impl GainScale {
    /// Makes a scale over the gains of some paths, at most 60 dB.
    pub fn over(paths: &[PathView]) -> Self {
        let gains = || paths.iter().map(|p| p.gain_db);
        let strongest_db = gains().fold(f64::NEG_INFINITY, f64::max);
        let weakest_db = gains().fold(strongest_db, f64::min);
        Self {
            strongest_db,
            weakest_db: weakest_db.max(strongest_db - RANGE_DB),
        }
    }

    /// The strongest gain \[dB\]; minus infinity without paths.
    pub fn strongest_db(&self) -> f64 {
        self.strongest_db
    }

    /// Place of a gain in the range, 0 to 1.
    fn part(&self, gain_db: f64) -> f64 {
        let range = self.strongest_db - self.weakest_db;
        if range > 0.0 {
            ((gain_db - self.weakest_db) / range).clamp(0.0, 1.0)
        } else {
            1.0
        }
    }

    /// Colour of a gain.
    pub fn colour(&self, gain_db: f64) -> Colour {
        Colour::strength(self.part(gain_db))
    }

    /// Width of the line of a path \[px\].
    pub fn width(&self, gain_db: f64) -> f64 {
        0.8 + 1.9 * self.part(gain_db)
    }

    /// The key of the colours, ending at `right` px; nothing without paths.
    pub fn key(&self, right: f64, y: f64) -> Group {
        let mut group = Group::new();
        if !self.strongest_db.is_finite() {
            return group;
        }
        let step = 14.0;
        let left = right - 78.0 - step * STRENGTH_STEPS as f64;
        for i in 0..STRENGTH_STEPS {
            let part = rectangle([left + step * i as f64, y], [step, 10.0]);
            group = group.add(part.set("class", Colour::Strength(i).fill()));
        }
        let end = left + step * STRENGTH_STEPS as f64;
        let weakest = format!("path gain {:.0}", self.weakest_db);
        let strongest = format!("{:.0} dB", self.strongest_db);
        group
            .add(anchored(&weakest, left - 5.0, y + 9.0, "end").set("class", "small"))
            .add(anchored(&strongest, end + 5.0, y + 9.0, "start").set("class", "small"))
    }
}
