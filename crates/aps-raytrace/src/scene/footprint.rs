//! Building outlines as they come in, before any check.

use glam::DVec2;

use crate::material::Material;

/// One building seen from above.
///
/// Rings may be open or closed (first vertex repeated at the end) and turn either way; repair
/// settles both. Coordinates in metres, x to the right, y upwards.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Footprint {
    /// Outer ring \[m\].
    pub outer: Vec<DVec2>,
    /// Courtyards \[m\].
    pub holes: Vec<Vec<DVec2>>,
    /// What its walls are made of; the tracer's default when none is given.
    pub material: Option<Material>,
}

impl Footprint {
    /// A building without courtyards, of the tracer's default material.
    #[must_use]
    pub fn new(outer: impl Into<Vec<DVec2>>) -> Self {
        Self {
            outer: outer.into(),
            ..Self::default()
        }
    }

    /// All rings, the outer one first.
    pub(crate) fn rings(&self) -> impl Iterator<Item = &[DVec2]> {
        std::iter::once(self.outer.as_slice()).chain(self.holes.iter().map(Vec::as_slice))
    }
}
