//! Building outlines as they come in, before any check.

use glam::DVec2;

use super::ring;
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
    /// Material of its walls; the tracer's default when none is given.
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

    /// The rings as they are meant, each with its index as given (0 for `outer`, then the holes): the outer one first. That is
    /// the largest of the holes where it surrounds `outer`, as in files that give a courtyard first.
    pub(crate) fn rings(&self) -> Vec<(usize, &[DVec2])> {
        let given = std::iter::once(&self.outer).chain(&self.holes);
        let mut rings: Vec<(usize, &[DVec2])> = given.map(Vec::as_slice).enumerate().collect();
        let area = |&(_, ring): &(usize, &[DVec2])| ring::doubled_area(ring).abs();
        let largest = rings.iter().max_by(|p, q| area(p).total_cmp(&area(q)));
        if let Some(&(i, around)) = largest
            && area(&(i, around)) > area(&rings[0])
            && self.outer.iter().all(|&p| ring::holds(around, p))
        {
            rings.swap(0, i);
        }
        rings
    }
}
