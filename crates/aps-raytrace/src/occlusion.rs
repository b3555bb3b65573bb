//! Decides which straight legs are free.
//!
//! The index selects walls whose boxes a leg may meet, generously; whether the leg meets the building behind one of them is decided
//! by exact orientation signs.

use crate::predicates::{orient, strictly_between};
use crate::scene::Wall;
use crate::wall_index::{HalfPlane, Selected, WallIndex};
use glam::DVec2;

/// A straight leg of a path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LegSegment {
    /// Both ends. Reflection points among them are rounded.
    pub ends: [DVec2; 2],
    /// Two points on the line, at the ends or beyond: a terminal, a corner or their images. They
    /// decide on which side of the line a corner lies.
    pub line: [DVec2; 2],
    /// The walls on whose fronts the ends lie, where they are reflection points.
    pub skip: [Option<u32>; 2],
}

impl LegSegment {
    /// The straight leg between two points.
    pub fn between(p: DVec2, q: DVec2) -> Self {
        Self {
            ends: [p, q],
            line: [p, q],
            skip: [None; 2],
        }
    }

    /// Returns true when the leg enters the building at this wall, whatever the others.
    pub fn is_blocked_by(&self, walls: &[Wall], wall: u32) -> bool {
        meets_building(walls, wall, self, &mut Touched::default())
    }

    /// Returns true when the leg meets the inside of a building: see [`crate::Scene::is_blocked`].
    pub fn is_blocked(&self, walls: &[Wall], index: &WallIndex) -> bool {
        let [p, q] = self.ends;
        let (min, max) = (p.min(q), p.max(q));
        let across = (q - p).perp();
        let limit = across.dot(p);
        let region = [
            (DVec2::X, min.x),
            (DVec2::NEG_X, -max.x),
            (DVec2::Y, min.y),
            (DVec2::NEG_Y, -max.y),
            (across, limit),
            (-across, -limit),
        ]
        .map(|(axis, limit)| HalfPlane { axis, limit });
        let mut near = Selected::new();
        index.select(&region, &mut near);
        let mut touched = Touched::default();
        near.into_iter().any(|id| {
            let is_skipped = |&s: &u32| is_at_or_behind(walls, id, s);
            !self.skip.iter().flatten().any(is_skipped)
                && meets_building(walls, id, self, &mut touched)
        })
    }
}

/// Returns true when wall `id` cannot be met by a leg that ends on the front of wall `skip`: it is
/// the same wall, or the next one around a convex corner, all of which lies behind. At a sharp
/// corner rounding of the leg's end may reach across the next one.
#[inline]
pub(crate) fn is_at_or_behind(walls: &[Wall], id: u32, skip: u32) -> bool {
    let wall = &walls[id as usize];
    id == skip
        || (wall.previous == skip && is_convex(walls, id))
        || (wall.next == skip && is_convex(walls, skip))
}

/// Returns true when the corner at the start of wall `id` points outwards.
pub(crate) fn is_convex(walls: &[Wall], id: u32) -> bool {
    let wall = &walls[id as usize];
    orient(walls[wall.previous as usize].a, wall.a, wall.b) > 0.0
}

/// Sides of a leg on which corners were touched so far.
#[derive(Default)]
struct Touched {
    left: bool,
    right: bool,
}

/// Returns true when a leg enters the building at wall `id` or at one of the wall's ends.
fn meets_building(walls: &[Wall], id: u32, leg: &LegSegment, touched: &mut Touched) -> bool {
    let Wall { a, b, .. } = walls[id as usize];
    let [from, to] = leg.line;
    let (side_a, side_b) = (orient(from, to, a), orient(from, to, b));
    if (side_a > 0.0 && side_b > 0.0) || (side_a < 0.0 && side_b < 0.0) {
        return false;
    }
    if side_a == 0.0 && enters_at_corner(walls, id, leg, touched) {
        return true;
    }
    if side_b == 0.0 && enters_at_corner(walls, walls[id as usize].next, leg, touched) {
        return true;
    }
    if side_a == 0.0 || side_b == 0.0 {
        return false;
    }
    // The line of the leg crosses the wall between its ends: where are the leg's own ends?
    // The building is to the left of a -> b.
    let [p, q] = leg.ends.map(|end| orient(a, b, end));
    (p > 0.0 && q <= 0.0) || (p <= 0.0 && q > 0.0)
}

/// Returns true when a leg whose line holds corner `id` (the start of wall `id`) passes it, or
/// begins or ends there, and is inside the building just before or after.
fn enters_at_corner(walls: &[Wall], id: u32, leg: &LegSegment, touched: &mut Touched) -> bool {
    let wall = &walls[id as usize];
    let (c, next) = (wall.a, wall.b);
    let [p, q] = leg.ends;
    let passes = strictly_between(p, q, c);
    if !passes && c != p && c != q {
        return false;
    }
    let previous = walls[wall.previous as usize].a;
    let convex = is_convex(walls, id);
    let [from, to] = leg.line;
    let inside = |x: DVec2| {
        let (left_of_in, left_of_out) = (orient(previous, c, x) > 0.0, orient(c, next, x) > 0.0);
        if convex {
            left_of_in && left_of_out
        } else {
            left_of_in || left_of_out
        }
    };
    if (c != p && inside(from)) || (c != q && inside(to)) {
        return true;
    }
    if !passes {
        return false;
    }
    for neighbour in [previous, next] {
        let side = orient(from, to, neighbour);
        touched.left |= side > 0.0;
        touched.right |= side < 0.0;
    }
    touched.left && touched.right
}

#[cfg(test)]
mod tests {
    use crate::scene::{Footprint, Scene};
    use glam::DVec2;

    fn rect(x0: f64, y0: f64, x1: f64, y1: f64) -> Footprint {
        Footprint::new([(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(DVec2::from))
    }

    #[track_caller]
    fn check(buildings: &[Footprint], p: (f64, f64), q: (f64, f64), blocked: bool) {
        let scene = Scene::new(buildings, None).unwrap();
        let (p, q) = (DVec2::from(p), DVec2::from(q));
        assert_eq!(scene.is_blocked(p, q), blocked, "forth");
        assert_eq!(scene.is_blocked(q, p), blocked, "back");
    }

    #[test]
    fn through_and_past_a_house() {
        let house = [rect(0.0, 0.0, 10.0, 10.0)];
        check(&house, (-5.0, 5.0), (15.0, 5.0), true);
        check(&house, (-5.0, 12.0), (15.0, 12.0), false);
        check(&house, (-5.0, 5.0), (-1.0, 5.0), false);
    }

    #[test]
    fn through_two_corners_of_a_house() {
        let house = [rect(0.0, 0.0, 10.0, 10.0)];
        check(&house, (-5.0, -5.0), (15.0, 15.0), true);
    }

    #[test]
    fn from_corner_to_corner_of_a_house() {
        let house = [rect(0.0, 0.0, 10.0, 10.0)];
        check(&house, (0.0, 0.0), (10.0, 10.0), true);
        check(&house, (10.0, 0.0), (0.0, 10.0), true);
        check(&house, (0.0, 0.0), (10.0, 0.0), false);
        check(&house, (0.0, 0.0), (-5.0, -5.0), false);
        // Out of a courtyard's corner, into the building around it.
        let angle = [
            (0.0, 0.0),
            (10.0, 0.0),
            (10.0, 4.0),
            (4.0, 4.0),
            (4.0, 10.0),
            (0.0, 10.0),
        ];
        let angle = [Footprint::new(angle.map(DVec2::from))];
        check(&angle, (4.0, 4.0), (0.0, 0.0), true);
        check(&angle, (4.0, 4.0), (10.0, 10.0), false);
        check(&angle, (10.0, 4.0), (4.0, 10.0), false);
    }

    #[test]
    fn touching_one_corner_is_free() {
        let house = [rect(0.0, 0.0, 10.0, 10.0)];
        check(&house, (-5.0, 5.0), (5.0, -5.0), false);
        check(&house, (5.0, 15.0), (15.0, 5.0), false);
    }

    #[test]
    fn along_a_wall_is_free() {
        let house = [rect(0.0, 0.0, 10.0, 10.0)];
        check(&house, (-5.0, 10.0), (15.0, 10.0), false);
        check(&house, (10.0, -5.0), (10.0, 25.0), false);
    }

    #[test]
    fn along_the_shared_wall_of_a_row_is_blocked() {
        let row = [rect(0.0, 0.0, 10.0, 10.0), rect(10.0, 0.0, 20.0, 10.0)];
        check(&row, (10.0, -5.0), (10.0, 15.0), true);
    }

    #[test]
    fn between_touching_corners_is_blocked() {
        let board = [rect(0.0, 0.0, 10.0, 10.0), rect(10.0, 10.0, 20.0, 20.0)];
        check(&board, (5.0, 15.0), (15.0, 5.0), true);
    }

    #[test]
    fn gap_of_width_zero_between_two_houses_is_blocked() {
        let street = [rect(0.0, 0.0, 10.0, 10.0), rect(20.0, 10.0, 30.0, 20.0)];
        check(&street, (-5.0, 10.0), (40.0, 10.0), true);
        check(&street, (-5.0, 10.0), (15.0, 10.0), false);
    }

    #[test]
    fn leg_that_ends_on_a_wall_is_free_from_the_street_only() {
        let house = [rect(0.0, 0.0, 10.0, 10.0)];
        check(&house, (5.0, -5.0), (5.0, 0.0), false);
        check(&house, (5.0, 15.0), (5.0, 0.0), true);
    }
}
