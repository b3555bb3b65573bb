//! Houses drawn, moved and taken away.

use aps_raytrace::Footprint;
use aps_raytrace::glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::fault::Fault;
use crate::limits::MAX_VERTICES;

/// Changes of a map. Houses are named by their place in the map as it was read; drawn ones follow.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Edits {
    /// Houses that were moved, and how far \[m\].
    pub moved: Vec<(usize, [f64; 2])>,
    /// Houses that were taken away.
    pub gone: Vec<usize>,
    /// Outer rings of houses that were drawn \[m\].
    pub drawn: Vec<Vec<[f64; 2]>>,
}

/// A house of a changed map.
#[derive(Debug, Clone)]
pub struct House {
    /// Its place in the map as it was read, or behind all of those.
    pub id: usize,
    /// Its outline.
    pub footprint: Footprint,
}

impl Edits {
    /// Returns true when nothing was changed.
    pub fn is_empty(&self) -> bool {
        self.moved.is_empty() && self.gone.is_empty() && self.drawn.is_empty()
    }

    /// The houses of a map after the changes.
    ///
    /// # Errors
    /// [`Fault::NoHouse`] and [`Fault::Vertices`].
    pub fn apply(&self, footprints: Vec<Footprint>) -> Result<Vec<House>, Fault> {
        let count = footprints.len();
        let vertices = self.drawn.iter().map(Vec::len).sum();
        if vertices > MAX_VERTICES {
            return Err(Fault::Vertices(vertices));
        }
        let named = self.moved.iter().map(|(house, _)| house).chain(&self.gone);
        if let Some(&house) = named.into_iter().find(|&&house| house >= count) {
            return Err(Fault::NoHouse { house, count });
        }
        let mut all: Vec<Option<Footprint>> = footprints.into_iter().map(Some).collect();
        for &(house, by) in &self.moved {
            if let Some(footprint) = &mut all[house] {
                let rings = std::iter::once(&mut footprint.outer).chain(&mut footprint.holes);
                rings.flatten().for_each(|p| *p += DVec2::from(by));
            }
        }
        for &house in &self.gone {
            all[house] = None;
        }
        let drawn = self.drawn.iter().map(|ring| {
            let ring: Vec<DVec2> = ring.iter().copied().map(DVec2::from).collect();
            Some(Footprint::new(ring))
        });
        let houses = all.into_iter().chain(drawn).enumerate();
        Ok(houses
            .filter_map(|(id, footprint)| footprint.map(|footprint| House { id, footprint }))
            .collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_houses() -> Vec<Footprint> {
        let house = |x: f64| Footprint::new([(x, 0.0), (x + 9.0, 0.0), (x, 9.0)].map(DVec2::from));
        vec![house(0.0), house(50.0)]
    }

    #[test]
    fn houses_keep_their_names_when_others_go() {
        let edits = Edits {
            moved: vec![(1, [0.5, -2.0])],
            gone: vec![0],
            drawn: vec![vec![[1.0, 2.0], [3.0, 2.0], [3.0, 4.0]]],
        };
        let houses = edits.apply(two_houses()).unwrap();
        let ids: Vec<usize> = houses.iter().map(|house| house.id).collect();
        assert_eq!(ids, [1, 2]);
        assert_eq!(houses[0].footprint.outer[0], DVec2::new(50.5, -2.0));
        assert_eq!(houses[1].footprint.outer[2], DVec2::new(3.0, 4.0));
    }

    #[test]
    fn houses_that_are_not_there_and_too_many_vertices_are_refused() {
        for edits in [
            Edits {
                gone: vec![2],
                ..Edits::default()
            },
            Edits {
                moved: vec![(usize::MAX, [0.0; 2])],
                ..Edits::default()
            },
        ] {
            let fault = edits.apply(two_houses()).unwrap_err();
            assert!(matches!(fault, Fault::NoHouse { count: 2, .. }));
        }
        let edits = Edits {
            drawn: vec![vec![[0.0; 2]; MAX_VERTICES + 1]],
            ..Edits::default()
        };
        assert!(matches!(
            edits.apply(Vec::new()),
            Err(Fault::Vertices(n)) if n == MAX_VERTICES + 1
        ));
    }
}
