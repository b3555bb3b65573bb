//! Slits between walls, too narrow to be meant, and the polygons that fill them.
//!
//! Houses in a row are often digitised with some millimetres between them. A wave whose field is parallel to the walls
//! does not pass a slit below half a wavelength (a parallel-plate guide below cut-off), a ray does. Such a slit is filled
//! where two walls face each other across the street at less than a tolerance: with the convex hull of those parts of
//! both walls that are nearer than the tolerance to the other one. Walls that touch leave no slit, and a wedge between
//! them stays open, since nothing passes it.
//!
//! The fillings depend on the walls alone, not on their order: each pair is judged by itself, its walls in the order
//! of their ends.

use glam::DVec2;
use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy};

use super::ring::{by_first_edge, by_height, edge_box, segments_meet};

/// Part of a filling's length by which it reaches into both walls, so that the grid's rounding leaves no slit beside it.
const OVERLAP_SHARE: f64 = 1.0 / 64.0;

/// Nearer to the end of a wall than this part of the width, a filling reaches the end: what would be left is no wall.
const TO_THE_END: f64 = 0.01;

/// An edge of the united outlines: the building to the left of `a` -> `b`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edge {
    pub a: DVec2,
    pub b: DVec2,
    pub building: usize,
    /// Index of the edge that begins where this one ends.
    pub next: usize,
}

/// The filling of one slit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Filling {
    /// The buildings on its sides, the lower one first.
    pub buildings: [usize; 2],
    /// A convex polygon, counter-clockwise \[m\].
    pub points: Vec<DVec2>,
}

/// Finds the slits narrower than `width_m` and fills them; a filling reaches up to `overlap_m` into its walls.
pub(super) fn fillings(edges: &[Edge], width_m: f64, overlap_m: f64) -> Vec<Filling> {
    let boxes: Vec<Aabb> = edges.iter().map(|e| edge_box(e.a, e.b)).collect();
    let bvh = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    let mut found = Vec::new();
    for (i, edge) in edges.iter().enumerate() {
        let around = Aabb::new(boxes[i].mins - width_m, boxes[i].maxs + width_m);
        let others = bvh.intersect_aabb(&around).map(|j| j as usize);
        found.extend(
            others
                .filter(|&j| {
                    j > i && !is_bay(edges, i, j, width_m) && !is_bay(edges, j, i, width_m)
                })
                .filter_map(|j| filling(edge, &edges[j], width_m, overlap_m)),
        );
    }
    found.sort_by(|p, q| by_first_edge(&p.points, &q.points));
    found
}

/// Tells if the walls that follow edge `from` up to edge `to` are all shorter than `width_m`: the two then close in a bay
/// with a dead end.
fn is_bay(edges: &[Edge], from: usize, to: usize, width_m: f64) -> bool {
    let mut at = edges[from].next;
    while at != to && at != from && edges[at].a.distance(edges[at].b) < width_m {
        at = edges[at].next;
    }
    at == to
}

/// The filling between two walls; `None` where they touch, are further apart or do not face each other.
fn filling(p: &Edge, q: &Edge, width_m: f64, overlap_m: f64) -> Option<Filling> {
    let order = by_first_edge(&[p.a, p.b], &[q.a, q.b]);
    let (p, q) = if order.is_le() { (p, q) } else { (q, p) };
    if segments_meet(p.a, p.b, q.a, q.b) {
        return None;
    }
    let [of_p, of_q] = [part_near(p, q, width_m)?, part_near(q, p, width_m)?];
    let (on_p, on_q) = nearest(p, q);
    let outward = |e: &Edge| DVec2::new(e.b.y - e.a.y, e.a.x - e.b.x);
    if !(outward(p).dot(on_q - on_p) > 0.0 && outward(q).dot(on_p - on_q) > 0.0) {
        return None;
    }
    let mut points: Vec<DVec2> = of_p.into_iter().chain(of_q).collect();
    for (edge, [from, to]) in [(p, of_p), (q, of_q)] {
        let depth = overlap_m.min(from.distance(to) * OVERLAP_SHARE);
        points.push(from.midpoint(to) - outward(edge).normalize_or_zero() * depth);
    }
    let points = convex_hull(points);
    let mut buildings = [p.building, q.building];
    buildings.sort_unstable();
    (points.len() >= 3).then_some(Filling { buildings, points })
}

/// The part of edge `p` that is nearer than `width_m` to edge `q`, from its start to its end, up to an end of `p` that is nearly
/// there.
fn part_near(p: &Edge, q: &Edge, width_m: f64) -> Option<[DVec2; 2]> {
    let along = p.b - p.a;
    let length = along.length();
    // Where the line p.a + t along is near an end of q: a chord of a circle.
    let chord = |centre: DVec2| {
        let middle = (centre - p.a).dot(along) / (length * length);
        let height = (centre - p.a).perp_dot(along) / length;
        match (width_m - height) * (width_m + height) {
            square if square > 0.0 => {
                let half = square.sqrt() / length;
                (middle - half, middle + half)
            }
            _ => NOWHERE,
        }
    };
    // Where it is beside q and near its line.
    let strip = || {
        let across = q.b - q.a;
        let size = across.length();
        let place = |p: DVec2| (p - q.a).dot(across) / size;
        let height = |p: DVec2| (p - q.a).perp_dot(across) / size;
        let beside = within(place(p.a), place(p.b), 0.0, size);
        let near = within(height(p.a), height(p.b), -width_m, width_m);
        (beside.0.max(near.0), beside.1.min(near.1))
    };
    // The distance to q is a convex function along p, so that the parts make one interval.
    let parts = [chord(q.a), chord(q.b), strip()].map(|(from, to)| (from.max(0.0), to.min(1.0)));
    let (from, to) = parts
        .into_iter()
        .filter(|(from, to)| from <= to)
        .reduce(|p, q| (p.0.min(q.0), p.1.max(q.1)))?;
    let rest = TO_THE_END * width_m / length;
    let at = |t: f64| match t {
        t if t <= rest => p.a,
        t if t >= 1.0 - rest => p.b,
        _ => p.a + along * t,
    };
    Some([at(from), at(to)])
}

/// An interval without a point.
const NOWHERE: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// The interval of t in which the value from `start` (t = 0) to `end` (t = 1) lies between `low` and `high`.
fn within(start: f64, end: f64, low: f64, high: f64) -> (f64, f64) {
    let slope = end - start;
    if slope == 0.0 {
        return match (low..=high).contains(&start) {
            true => (0.0, 1.0),
            false => NOWHERE,
        };
    }
    let [s, t] = [(low - start) / slope, (high - start) / slope];
    (s.min(t), s.max(t))
}

/// The points of two edges that do not meet which are nearest to each other.
fn nearest(p: &Edge, q: &Edge) -> (DVec2, DVec2) {
    let foot = |point: DVec2, e: &Edge| {
        let along = e.b - e.a;
        let t = (point - e.a).dot(along) / along.length_squared();
        e.a + along * t.clamp(0.0, 1.0)
    };
    let pairs = [
        (p.a, foot(p.a, q)),
        (p.b, foot(p.b, q)),
        (foot(q.a, p), q.a),
        (foot(q.b, p), q.b),
    ];
    let distance = |pair: &(DVec2, DVec2)| pair.0.distance_squared(pair.1);
    let nearer = |x: &(DVec2, DVec2), y: &(DVec2, DVec2)| distance(x).total_cmp(&distance(y));
    pairs.into_iter().min_by(nearer).expect("there are four")
}

/// The convex hull, counter-clockwise from the lowest, then leftmost point (Andrew's monotone chain).
fn convex_hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(by_height);
    points.dedup();
    let mut hull: Vec<DVec2> = Vec::with_capacity(points.len() + 1);
    for chain in [
        &mut points.iter() as &mut dyn Iterator<Item = &DVec2>,
        &mut points.iter().rev(),
    ] {
        let start = hull.len();
        for &p in chain {
            while hull.len() >= start + 2
                && (hull[hull.len() - 1] - hull[hull.len() - 2]).perp_dot(p - hull[hull.len() - 2])
                    <= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::super::ring::doubled_area;
    use super::*;

    fn edge(a: (f64, f64), b: (f64, f64), building: usize, next: usize) -> Edge {
        let (a, b) = (a.into(), b.into());
        Edge {
            a,
            b,
            building,
            next,
        }
    }

    /// Fillings between the east wall of a house and another wall, of a building of its own or of the same.
    fn found(a: (f64, f64), b: (f64, f64), building: usize) -> Vec<Filling> {
        // Each is followed by itself: there is no bay between them.
        let east = |next| edge((1.0, 0.0), (1.0, 10.0), 0, next);
        let forth = fillings(&[east(0), edge(a, b, building, 1)], 0.04, 1e-6);
        let back = fillings(&[edge(a, b, building, 0), east(1)], 0.04, 1e-6);
        assert_eq!(forth, back, "the order matters");
        forth
    }

    #[track_caller]
    fn check(a: (f64, f64), b: (f64, f64), building: usize, expected: Option<f64>) {
        let found = found(a, b, building);
        let area = found.first().map(|f| doubled_area(&f.points) / 2.0);
        match (area, expected) {
            (None, None) => {}
            (Some(area), Some(expected)) => assert!((area - expected).abs() < 2e-5, "{area}"),
            _ => panic!("{area:?} instead of {expected:?}"),
        }
    }

    #[test]
    fn facing_walls_are_joined_over_their_whole_length() {
        check((1.01, 10.0), (1.01, 0.0), 1, Some(0.1));
        check((1.05, 10.0), (1.05, 0.0), 1, None);
    }

    #[test]
    fn longer_wall_is_joined_as_far_as_it_is_near() {
        // The shorter wall, 2 m, and at each end 0.0387 m of the longer one, at which the slit is 0.01 m wide.
        let reach = (0.04_f64.powi(2) - 0.01_f64.powi(2)).sqrt();
        check((1.01, 6.0), (1.01, 4.0), 1, Some(0.01 * (2.0 + reach)));
    }

    #[test]
    fn back_to_back_walls_of_a_thin_house_are_left() {
        check((0.99, 10.0), (0.99, 0.0), 0, None);
    }

    #[test]
    fn touching_walls_are_left() {
        check((1.03, 10.0), (1.0, 0.0), 1, None);
        check((1.03, 5.0), (1.0, 3.0), 1, None);
    }

    #[test]
    fn corners_across_a_slit_are_joined() {
        let points = &found((2.0, -0.02), (1.02, -0.02), 1)[0].points;
        assert!(
            points.contains(&DVec2::new(1.0, 0.0)) && points.contains(&DVec2::new(1.02, -0.02))
        );
    }
}
