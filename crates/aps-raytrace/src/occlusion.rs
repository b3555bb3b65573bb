//! Decides which straight legs are free: an index over the walls, and exact tests of its candidates.
//!
//! parry's bounding volume hierarchy selects walls whose boxes a leg may meet, generously; whether
//! the leg meets the building behind one of them is decided by exact orientation signs.

use glam::DVec2;
use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode, TraversalAction};

use crate::predicates::{orient, strictly_between};
use crate::scene::Wall;

/// Boxes grow by this part of the scene's size, far more than rounding can take away.
const BOX_MARGIN: f64 = 1e-9;

/// A straight leg of a path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stretch {
    /// Where it begins and ends. Reflection points among them are rounded.
    pub ends: [DVec2; 2],
    /// Two points on its line, at its ends or beyond: a terminal, a corner or their images. They
    /// decide on which side of the line a corner lies.
    pub line: [DVec2; 2],
    /// The walls on whose fronts the ends lie, where they are reflection points.
    pub skip: [Option<u32>; 2],
}

/// Bounding volume hierarchy over the walls of a scene.
#[derive(Debug, Clone)]
pub(crate) struct WallIndex {
    bvh: Bvh,
}

impl WallIndex {
    pub fn new(walls: &[Wall]) -> Self {
        let extent = walls
            .iter()
            .map(|w| w.a.abs().max(w.b.abs()).max_element())
            .fold(0.0, f64::max);
        let margin = extent * BOX_MARGIN;
        let boxes: Vec<Aabb> = walls
            .iter()
            .map(|w| Aabb::new(w.a.min(w.b) - margin, w.a.max(w.b) + margin))
            .collect();
        Self {
            bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
        }
    }

    /// Visits the walls whose boxes `select` accepts, given centre and half extents, until
    /// `visit` returns false.
    #[inline]
    pub fn for_each(
        &self,
        mut select: impl FnMut(DVec2, DVec2) -> bool,
        mut visit: impl FnMut(u32) -> bool,
    ) {
        self.bvh.traverse(|node: &BvhNode| {
            let (min, max) = (node.mins(), node.maxs());
            if !select((min + max) * 0.5, (max - min) * 0.5) {
                return TraversalAction::Prune;
            }
            match node.leaf_data() {
                Some(wall) if !visit(wall) => TraversalAction::EarlyExit,
                _ => TraversalAction::Continue,
            }
        });
    }

    /// See [`crate::Scene::is_blocked`].
    pub fn is_blocked(&self, walls: &[Wall], leg: &Stretch) -> bool {
        let [p, q] = leg.ends;
        let middle = p.midpoint(q);
        let half = (q - p) * 0.5;
        let span = half.abs();
        let meets_box = |centre: DVec2, extent: DVec2| {
            let r = centre - middle;
            let reach = extent + span;
            r.x.abs() <= reach.x
                && r.y.abs() <= reach.y
                && half.perp_dot(r).abs() <= extent.x * span.y + extent.y * span.x
        };
        let mut grazed = Grazed::default();
        let mut blocked = false;
        self.for_each(meets_box, |id| {
            if !leg
                .skip
                .iter()
                .flatten()
                .any(|&s| is_at_or_behind(walls, id, s))
            {
                blocked = meets_building(walls, id, leg, &mut grazed);
            }
            !blocked
        });
        blocked
    }
}

/// Returns true when wall `id` cannot be met by a leg that ends on the front of wall `skip`: it is
/// the same wall, or the next one around a convex corner, all of which lies behind. At a sharp
/// corner rounding of the leg's end may reach across the next one.
#[inline]
fn is_at_or_behind(walls: &[Wall], id: u32, skip: u32) -> bool {
    let wall = &walls[id as usize];
    id == skip
        || (wall.previous == skip && is_convex(walls, id))
        || (wall.next == skip && is_convex(walls, skip))
}

/// Returns true when the corner at the start of wall `id` points outwards.
fn is_convex(walls: &[Wall], id: u32) -> bool {
    let wall = &walls[id as usize];
    orient(walls[wall.previous as usize].a, wall.a, wall.b) > 0.0
}

/// On which sides of a leg corners were touched so far.
#[derive(Default)]
struct Grazed {
    left: bool,
    right: bool,
}

/// Returns true when a leg enters the building at wall `id` or at one of the wall's ends.
fn meets_building(walls: &[Wall], id: u32, leg: &Stretch, grazed: &mut Grazed) -> bool {
    let Wall { a, b, .. } = walls[id as usize];
    let [from, to] = leg.line;
    let (side_a, side_b) = (orient(from, to, a), orient(from, to, b));
    if (side_a > 0.0 && side_b > 0.0) || (side_a < 0.0 && side_b < 0.0) {
        return false;
    }
    if side_a == 0.0 && enters_at_corner(walls, id, leg, grazed) {
        return true;
    }
    if side_b == 0.0 && enters_at_corner(walls, walls[id as usize].next, leg, grazed) {
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
fn enters_at_corner(walls: &[Wall], id: u32, leg: &Stretch, grazed: &mut Grazed) -> bool {
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
        grazed.left |= side > 0.0;
        grazed.right |= side < 0.0;
    }
    grazed.left && grazed.right
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
        assert_eq!(scene.is_blocked(p, q, [None; 2]), blocked, "forth");
        assert_eq!(scene.is_blocked(q, p, [None; 2]), blocked, "back");
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
        check(
            &[rect(0.0, 0.0, 10.0, 10.0)],
            (-5.0, -5.0),
            (15.0, 15.0),
            true,
        );
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
