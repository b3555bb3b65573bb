//! Location of a point: outdoors, on a wall or in a building. Exact.

use glam::DVec2;

use super::ring::{is_on_edge, is_position, winding_step};
use super::{Area, Scene, Wall};
use crate::error::TerminalError;
use crate::predicates::{orient, strictly_between};

/// Place of a point in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Location {
    /// Strictly outside all buildings and within the area: a place for a terminal.
    Outdoor,
    /// Exactly on a wall.
    OnWall {
        /// The wall with the lowest id that holds the point.
        wall: u32,
    },
    /// Strictly inside a building.
    Inside {
        /// The building, by its index among the footprints; where several overlap, one of them.
        building: usize,
    },
    /// Outside the scene's area.
    OutsideArea,
}

impl Scene {
    /// Locates a point with finite coordinates. Costs O(log n + k) for k walls at its height.
    #[must_use]
    pub fn locate(&self, p: DVec2) -> Location {
        match self.area {
            Some(area) if !area.contains(p) => Location::OutsideArea,
            _ => self.locate_anywhere(p),
        }
    }

    /// Locates a point, whatever the area.
    fn locate_anywhere(&self, p: DVec2) -> Location {
        let mut on_wall: Option<u32> = None;
        let mut winding = 0;
        let mut nearest = (f64::INFINITY, 0);
        let right_of_p = |centre: DVec2, extent: DVec2| {
            (centre.y - p.y).abs() <= extent.y && centre.x + extent.x >= p.x
        };
        self.index.for_each(right_of_p, |id| {
            let wall = &self.walls[id as usize];
            let (a, b) = (wall.a, wall.b);
            if is_on_edge(a, b, p) {
                on_wall = Some(on_wall.map_or(id, |w| w.min(id)));
            }
            let step = winding_step(a, b, p);
            if step != 0 {
                winding += step;
                let x = a.x + (p.y - a.y) * (b.x - a.x) / (b.y - a.y);
                if (x, wall.building) < nearest {
                    nearest = (x, wall.building);
                }
            }
            true
        });
        match on_wall {
            Some(wall) => Location::OnWall { wall },
            None if winding != 0 => Location::Inside {
                building: nearest.1,
            },
            None => Location::Outdoor,
        }
    }

    /// Tells if the open segment between two different points meets a building, walls included. Exact for walls, and the same
    /// in both directions. Costs as [`Scene::locate`].
    #[must_use]
    pub fn touches_building(&self, p: DVec2, q: DVec2) -> bool {
        let (min, max) = (p.min(q), p.max(q));
        let mut is_touched = false;
        let near = |centre: DVec2, extent: DVec2| {
            (centre + extent).cmpge(min).all() && (centre - extent).cmple(max).all()
        };
        self.index.for_each(near, |id| {
            let wall = &self.walls[id as usize];
            is_touched = is_touched || meets_open_segment(wall, p, q);
            !is_touched
        });
        // Without a wall on the way all of it is as its middle is; an end may be on a wall.
        let middle = self.locate_anywhere(p.midpoint(q));
        is_touched || matches!(middle, Location::Inside { .. })
    }

    /// The innermost courtyard around an outdoor point, closed on all sides; `None` in the open.
    ///
    /// Waves in the plane cannot leave a courtyard: two points in different ones have no path.
    #[must_use]
    pub fn courtyard_of(&self, p: DVec2) -> Option<usize> {
        let mut courtyards = self.courtyards.iter();
        courtyards.position(|ring| self.winds_around(ring, p))
    }

    /// Tells if a ring of walls winds around a point.
    fn winds_around(&self, ring: &[u32], p: DVec2) -> bool {
        let walls = ring.iter().map(|&id| &self.walls[id as usize]);
        let steps = walls.map(|wall| winding_step(wall.a, wall.b, p));
        steps.sum::<i32>() != 0
    }

    /// Tells for each courtyard if any of `points` lies in it or on its walls. Where none does, nothing in that courtyard
    /// meets any of them.
    pub(crate) fn courtyards_with(&self, points: impl Iterator<Item = DVec2> + Clone) -> Vec<bool> {
        let holds = |ring: &[u32], p: DVec2| {
            let mut walls = ring.iter().map(|&id| &self.walls[id as usize]);
            self.winds_around(ring, p) || walls.any(|w| is_on_edge(w.a, w.b, p))
        };
        let rings = self.courtyards.iter();
        rings
            .map(|ring| points.clone().any(|p| holds(ring, p)))
            .collect()
    }

    /// Checks that a terminal can stand at `p`.
    ///
    /// # Errors
    /// [`TerminalError`] for coordinates that are not finite or beyond 1e9 m and for every place but
    /// [`Location::Outdoor`].
    pub fn check_terminal(&self, p: DVec2) -> Result<(), TerminalError> {
        if !is_position(p) {
            return Err(TerminalError::NotFinite(p.x, p.y));
        }
        let position = p;
        Err(match self.locate(position) {
            Location::Outdoor => return Ok(()),
            Location::OnWall { wall } => TerminalError::OnWall { position, wall },
            Location::Inside { building } => TerminalError::InsideBuilding { position, building },
            Location::OutsideArea => {
                let area = self.area;
                let Area { min, max } = area.expect("only a scene with an area has an outside");
                TerminalError::OutsideArea { position, min, max }
            }
        })
    }
}

/// Tells if a wall, ends included, has a point between `p` and `q`, these excluded.
fn meets_open_segment(wall: &Wall, p: DVec2, q: DVec2) -> bool {
    let (a, b) = (wall.a, wall.b);
    let [of_p, of_q] = [orient(a, b, p), orient(a, b, q)];
    if of_p == 0.0 && of_q == 0.0 {
        let is_between = |c| strictly_between(p, q, c);
        // On one line: they overlap where the wall begins or ends in between, or reaches over both.
        return is_between(a) || is_between(b) || strictly_between(a, b, p.midpoint(q));
    }
    let [of_a, of_b] = [orient(p, q, a), orient(p, q, b)];
    let apart = |s: f64, t: f64| (s < 0.0 && t > 0.0) || (s > 0.0 && t < 0.0);
    apart(of_p, of_q) && (apart(of_a, of_b) || of_a == 0.0 || of_b == 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Footprint;

    #[test]
    fn courtyard_building_has_all_four_places() {
        let square = |lo: f64, hi: f64| [(lo, lo), (hi, lo), (hi, hi), (lo, hi)].map(DVec2::from);
        let footprint = Footprint {
            outer: square(2.0, 10.0).into(),
            holes: vec![square(4.0, 8.0).into()],
            material: None,
        };
        let area = Area {
            min: DVec2::ZERO,
            max: DVec2::splat(12.0),
        };
        let scene = Scene::new(&[footprint], Some(area)).unwrap();
        let at = |x: f64, y: f64| scene.locate(DVec2::new(x, y));
        assert_eq!(at(1.0, 1.0), Location::Outdoor);
        assert_eq!(at(6.0, 6.0), Location::Outdoor);
        assert_eq!(at(3.0, 4.0), Location::Inside { building: 0 });
        assert_eq!(at(1.0, 4.0), Location::Outdoor);
        assert!(matches!(at(4.0, 5.0), Location::OnWall { .. }));
        assert!(matches!(at(2.0, 2.0), Location::OnWall { .. }));
        assert_eq!(at(-1.0, 5.0), Location::OutsideArea);
        assert_eq!(scene.courtyard_of(DVec2::new(6.0, 6.0)), Some(0));
        assert_eq!(scene.courtyard_of(DVec2::new(1.0, 6.0)), None);
        assert!(scene.check_terminal(DVec2::new(f64::NAN, 0.0)).is_err());
    }
}
