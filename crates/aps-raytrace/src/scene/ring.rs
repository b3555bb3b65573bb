//! Cleaning of single rings: closing vertex, duplicates, collinear vertices, orientation.

use std::cmp::Ordering;

use glam::DVec2;
use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy};

use super::repair::{RepairKind, RepairReport};
use crate::error::SceneError;
use crate::predicates::orient;

/// Largest magnitude of a coordinate \[m\]: far beyond any map projection, far below overflow.
const MAX_COORDINATE_M: f64 = 1e9;

/// Tells if a point is finite and its coordinates are within [`MAX_COORDINATE_M`].
pub(super) fn is_position(p: DVec2) -> bool {
    p.is_finite() && p.abs().max_element() <= MAX_COORDINATE_M
}

/// Lower left and upper right corner of the box around some points; without any, inside out: the first is infinite.
pub(super) fn bounds(points: impl Iterator<Item = DVec2>) -> (DVec2, DVec2) {
    points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), p| {
        (min.min(p), max.max(p))
    })
}

/// Box around the edge from `a` to `b`.
pub(super) fn edge_box(a: DVec2, b: DVec2) -> Aabb {
    Aabb::new(a.min(b), a.max(b))
}

/// Order of finite points: the lowest first, then the leftmost.
pub(super) fn by_height(p: &DVec2, q: &DVec2) -> Ordering {
    let order = (p.y, p.x).partial_cmp(&(q.y, q.x));
    order.expect("coordinates are finite")
}

/// Order of rings by their first edge.
pub(super) fn by_first_edge(p: &[DVec2], q: &[DVec2]) -> Ordering {
    by_height(&p[0], &q[0]).then_with(|| by_height(&p[1], &q[1]))
}

/// Number of different points, or 3 if there are more.
pub(super) fn distinct_up_to_3(points: &[DVec2]) -> usize {
    let Some(a) = points.first() else {
        return 0;
    };
    let Some(b) = points.iter().find(|&p| p != a) else {
        return 1;
    };
    2 + usize::from(points.iter().any(|p| p != a && p != b))
}

/// Removes the vertices of a ring that `is_needless` names, which is given the vertex before, the vertex and the one after. Each
/// removal can make the neighbours needless in turn: it looks again until nothing changes, or two are left.
pub(super) fn prune<T>(ring: &mut Vec<T>, mut is_needless: impl FnMut(&T, &T, &T) -> bool) {
    let mut i = 0;
    let mut unchanged = 0;
    while ring.len() >= 3 && unchanged < ring.len() {
        let n = ring.len();
        i %= n;
        if is_needless(&ring[(i + n - 1) % n], &ring[i], &ring[(i + 1) % n]) {
            ring.remove(i);
            i = (i + ring.len() - 1) % ring.len();
            unchanged = 0;
        } else {
            i += 1;
            unchanged += 1;
        }
    }
}

/// A ring and, for each of its vertices, the index it had in the input.
pub(super) struct Ring {
    pub points: Vec<DVec2>,
    pub source: Vec<usize>,
}

/// Twice the signed area \[m^2\]; positive counter-clockwise. Taken about the first vertex, so
/// that a distant origin costs no digits.
pub(super) fn doubled_area(points: &[DVec2]) -> f64 {
    let Some(&origin) = points.first() else {
        return 0.0;
    };
    points
        .windows(2)
        .map(|w| (w[0] - origin).perp_dot(w[1] - origin))
        .sum()
}

/// Tells if a ring, taken as closed, winds around a point or runs through it. Exact.
pub(super) fn holds(ring: &[DVec2], p: DVec2) -> bool {
    let edges = || {
        let following = ring.iter().copied().cycle().skip(1);
        ring.iter().copied().zip(following)
    };
    let winding: i32 = edges().map(|(a, b)| winding_step(a, b, p)).sum();
    winding != 0 || edges().any(|(a, b)| is_on_edge(a, b, p))
}

/// Tells if a point lies on the closed edge from `a` to `b`. Exact.
pub(super) fn is_on_edge(a: DVec2, b: DVec2, p: DVec2) -> bool {
    let in_box = p.cmpge(a.min(b)).all() && p.cmple(a.max(b)).all();
    in_box && orient(a, b, p) == 0.0
}

/// Contribution of the edge from `a` to `b` to the winding number around `p`: 1 where it crosses the ray to the right of `p`
/// upwards, -1 downwards. Half-open in y, so that a corner at p's height counts once.
pub(super) fn winding_step(a: DVec2, b: DVec2, p: DVec2) -> i32 {
    match (a.y <= p.y, b.y <= p.y) {
        (true, false) if orient(a, b, p) > 0.0 => 1,
        (false, true) if orient(a, b, p) < 0.0 => -1,
        _ => 0,
    }
}

/// Removes the closing vertex, duplicates and collinear vertices and turns the ring
/// counter-clockwise (an outer ring) or clockwise (a hole).
///
/// Returns `None` when nothing is left that encloses an area.
pub(super) fn clean(
    building: usize,
    ring: usize,
    is_outer: bool,
    points: &[DVec2],
    report: &mut RepairReport,
) -> Result<Option<Ring>, SceneError> {
    check_coordinates(building, ring, points)?;
    check_distinct(building, ring, points)?;

    let mut kept: Vec<(DVec2, usize)> = points.iter().copied().zip(0..).collect();
    if kept.len() > 1 && kept[0].0 == kept[kept.len() - 1].0 {
        kept.pop();
    }
    // A spike folds up from its tip.
    prune(&mut kept, |&(previous, _), &(here, vertex), &(next, _)| {
        let kind = if here == previous {
            RepairKind::DuplicateVertex { vertex }
        } else if here != next && orient(previous, here, next) == 0.0 {
            RepairKind::CollinearVertex { vertex }
        } else {
            return false;
        };
        report.push(building, kind);
        true
    });
    if kept.len() < 3 {
        report.push(building, RepairKind::Sliver);
        return Ok(None);
    }
    let (mut points, mut source): (Vec<_>, Vec<_>) = kept.into_iter().unzip();
    let is_counter_clockwise = doubled_area(&points) > 0.0;
    if is_counter_clockwise != is_outer {
        report.push(building, RepairKind::Reoriented);
        points.reverse();
        source.reverse();
    }
    Ok(Some(Ring { points, source }))
}

/// Reports edges of one ring that meet other than at their common vertex.
pub(super) fn report_crossings(building: usize, ring: &Ring, report: &mut RepairReport) {
    let points = &ring.points;
    let n = points.len();
    let edge = |i: usize| (points[i], points[(i + 1) % n]);
    let boxes: Vec<Aabb> = (0..n).map(edge).map(|(a, b)| edge_box(a, b)).collect();
    let bvh = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    for (i, around) in boxes.iter().enumerate() {
        let (a, b) = edge(i);
        let crosses = bvh.intersect_aabb(around).map(|j| j as usize).any(|j| {
            let apart = j > i && j - i > 1 && !(i == 0 && j == n - 1);
            apart && segments_meet(a, b, edge(j).0, edge(j).1)
        });
        if crosses {
            let vertex = ring.source[i];
            report.push(building, RepairKind::SelfIntersection { vertex });
        }
    }
}

/// Tells if two closed segments share a point; segments on one line must have boxes that overlap.
pub(super) fn segments_meet(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let apart = |s: f64, t: f64| (s > 0.0 && t > 0.0) || (s < 0.0 && t < 0.0);
    !apart(orient(a, b, c), orient(a, b, d)) && !apart(orient(c, d, a), orient(c, d, b))
}

fn check_coordinates(building: usize, ring: usize, points: &[DVec2]) -> Result<(), SceneError> {
    match points.iter().position(|&p| !is_position(p)) {
        None => Ok(()),
        Some(vertex) => Err(SceneError::Coordinate {
            building,
            ring,
            vertex,
            x: points[vertex].x,
            y: points[vertex].y,
        }),
    }
}

fn check_distinct(building: usize, ring: usize, points: &[DVec2]) -> Result<(), SceneError> {
    match distinct_up_to_3(points) {
        3 => Ok(()),
        distinct => Err(SceneError::TooFewVertices {
            building,
            ring,
            vertex: points.len().saturating_sub(1),
            distinct,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(points: &[(f64, f64)], left: usize, report: &str) {
        let points: Vec<DVec2> = points.iter().map(|&p| p.into()).collect();
        let mut found = RepairReport::default();
        let ring = clean(0, 0, true, &points, &mut found).unwrap();
        let count = ring.map_or(0, |r| {
            assert!(doubled_area(&r.points) > 0.0);
            r.points.len()
        });
        assert_eq!((count, found.to_string().as_str()), (left, report));
    }

    #[test]
    fn closed_square_is_clean() {
        check(
            &[(0., 0.), (2., 0.), (2., 2.), (0., 2.), (0., 0.)],
            4,
            "clean",
        );
    }

    #[test]
    fn clockwise_square_is_turned() {
        check(&[(0., 0.), (0., 2.), (2., 2.), (2., 0.)], 4, "1 reoriented");
    }

    #[test]
    fn repeated_and_collinear_vertices_go() {
        check(
            &[(0., 0.), (1., 0.), (2., 0.), (2., 0.), (2., 2.), (0., 2.)],
            4,
            "1 duplicate vertex, 1 collinear vertex",
        );
    }

    #[test]
    fn spike_folds_up_from_its_tip() {
        check(
            &[
                (0., 0.),
                (2., 0.),
                (2., 1.),
                (5., 1.),
                (2., 1.),
                (2., 2.),
                (0., 2.),
            ],
            4,
            "1 duplicate vertex, 2 collinear vertices",
        );
    }

    #[test]
    fn flat_ring_is_a_sliver() {
        check(
            &[(0., 0.), (1., 1.), (2., 2.), (0., 0.)],
            0,
            "1 collinear vertex, 1 sliver dropped",
        );
    }

    #[test]
    fn two_points_are_an_error_naming_the_place() {
        let p = [DVec2::ZERO, DVec2::X, DVec2::ZERO];
        let e = clean(7, 0, true, &p, &mut RepairReport::default())
            .err()
            .unwrap();
        assert!(
            e.to_string().contains("building 7, ring 0, vertex 2"),
            "{e}"
        );
    }
}
