//! Decides which features are buildings with walls.

use super::document::Feature;

/// Values of `building` that are not one, or have no walls.
const NO_WALLS: [&str; 3] = ["no", "roof", "carport"];

/// States in which a building does not stand, or no wall can be counted on: not built yet, or not there any more.
/// OpenStreetMap has them as values of `building` (`building=construction`) and as keys beside it (`ruins=yes`). What is
/// `abandoned` or `disused` stands.
const NOT_STANDING: [&str; 10] = [
    "planned",
    "proposed",
    "construction",
    "ruins",
    "collapsed",
    "destroyed",
    "demolished",
    "dismantled",
    "razed",
    "removed",
];

/// Kind of a feature, by its tags.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A building with walls.
    Building,
    /// A building in one of the states of [`NOT_STANDING`].
    NotStanding,
    /// Anything else.
    Other,
}

impl Kind {
    pub(super) fn of(feature: &Feature) -> Self {
        let is = |key, value: &str| feature.tag(key).and_then(|v| v.as_str()) == Some(value);
        let layer = feature.tag("layer").and_then(|v| match v.as_str() {
            Some(text) => text.trim().parse().ok(),
            None => v.as_f64(),
        });
        let has_walls = feature.tag("building").is_some_and(|v| v != false)
            && !NO_WALLS.iter().any(|value| is("building", value))
            && !is("location", "underground")
            && layer.is_none_or(|layer| layer >= 0.0);
        let stands = || {
            let mut states = NOT_STANDING.iter();
            !states.any(|state| is("building", state) || is(state, "yes"))
        };
        match has_walls {
            true if stands() => Self::Building,
            true => Self::NotStanding,
            false => Self::Other,
        }
    }
}
