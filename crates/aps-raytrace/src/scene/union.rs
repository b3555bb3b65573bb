//! The union of all buildings: the outlines that waves can meet.
//!
//! The Boolean operations run in integers (crate `i_overlay`), on a grid so fine (2^-40 of the
//! scene's extent, 2e-10 m for a 256 m map) that integer metres are exact on it. Vertices of the
//! input come back with the bits they had; only points where two walls cross are rounded to the
//! grid.

use std::collections::HashMap;

use glam::DVec2;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{IntOverlayOptions, Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::relate::PredicateOverlay;
use i_overlay::i_float::int::point::IntPoint;
use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy};

use super::repair::{RepairKind, RepairReport};
use super::ring::Ring;
use crate::predicates::orient;

type Contour = Vec<IntPoint<i64>>;

/// Cells along the scene's longer side, as a power of two.
const GRID_BITS: i32 = 40;
/// How far, in cells, rounding of crossings may bend an edge.
const TOLERANCE_CELLS: f64 = 8.0;

/// One closed outline of the union: interior to the left of every edge.
pub(super) struct Outline {
    /// Vertices \[m\].
    pub points: Vec<DVec2>,
    /// Building that the edge starting at each vertex belongs to.
    pub edge_building: Vec<usize>,
}

/// Unites cleaned buildings (outer ring counter-clockwise, holes clockwise).
///
/// `same_material` tells whether flush walls of two buildings may become one.
pub(super) fn unite(
    buildings: &[(usize, Vec<Ring>)],
    same_material: impl Fn(usize, usize) -> bool,
    report: &mut RepairReport,
) -> Vec<Outline> {
    let Some(grid) = Grid::fit(buildings) else {
        return Vec::new();
    };
    let shapes: Vec<(usize, Vec<Contour>)> = buildings
        .iter()
        .map(|(building, rings)| (*building, grid.resolve(rings)))
        .filter(|(building, contours)| {
            // Its holes leave nothing of it.
            let is_gone = contours.iter().all(Vec::is_empty);
            if is_gone {
                report.push(*building, RepairKind::Sliver);
            }
            !is_gone
        })
        .collect();
    report_contacts(&shapes, report);

    let mut overlay = keeping_collinear(buildings.iter().map(|b| b.1.len() * 8).sum());
    for (_, contours) in &shapes {
        overlay.add_source(contours, ShapeType::Subject);
    }
    let edges = InputEdges::new(buildings);
    let mut outlines: Vec<Outline> = overlay
        .overlay(OverlayRule::Subject, FillRule::NonZero)
        .into_iter()
        .flatten()
        .filter_map(|contour| {
            let points = contour.iter().map(|&p| grid.to_metres(p)).collect();
            grid.outline(points, &edges, &same_material)
        })
        .collect();
    // An order of our own: wall ids must not depend on how the union was computed.
    outlines.sort_by(|p, q| {
        let key = |o: &Outline| (o.points[0].y, o.points[0].x, o.points[1].y, o.points[1].x);
        key(p).partial_cmp(&key(q)).expect("coordinates are finite")
    });
    outlines
}

fn keeping_collinear(capacity: usize) -> Overlay<i64> {
    Overlay::new_custom(
        capacity,
        IntOverlayOptions::keep_output_points(),
        Default::default(),
    )
}

/// Says which buildings overlap or touch.
fn report_contacts(shapes: &[(usize, Vec<Contour>)], report: &mut RepairReport) {
    let bounds: Vec<Aabb> = shapes
        .iter()
        .map(|(_, contours)| {
            let points = contours.iter().flatten();
            Aabb::from_points(points.map(|p| DVec2::new(p.x as f64, p.y as f64)))
        })
        .collect();
    let bvh = Bvh::from_leaves(BvhBuildStrategy::Binned, &bounds);
    for (i, (building, contours)) in shapes.iter().enumerate() {
        let mut others: Vec<usize> = bvh
            .intersect_aabb(&bounds[i])
            .map(|j| j as usize)
            .filter(|&j| j > i)
            .collect();
        others.sort_unstable();
        for j in others {
            let other = shapes[j].0;
            let mut relation = PredicateOverlay::from_subj_and_clip(contours, &shapes[j].1);
            if relation.interiors_intersect() {
                report.push(*building, RepairKind::Overlaps { other });
                continue;
            }
            let mut relation = PredicateOverlay::from_subj_and_clip(contours, &shapes[j].1);
            if relation.intersects() {
                report.push(*building, RepairKind::Touches { other });
            }
        }
    }
}

/// The integer grid of one scene.
struct Grid {
    origin: DVec2,
    cell_m: f64,
    /// The input's own coordinates by cell.
    vertices: HashMap<(i64, i64), DVec2>,
}

impl Grid {
    fn fit(buildings: &[(usize, Vec<Ring>)]) -> Option<Self> {
        let points = || {
            buildings
                .iter()
                .flat_map(|(_, rings)| rings)
                .flat_map(|r| r.points.iter().copied())
        };
        let min = points().reduce(DVec2::min)?;
        let max = points().reduce(DVec2::max)?;
        let extent = (max - min).max_element();
        let cell_m = f64::exp2(extent.log2().ceil() - f64::from(GRID_BITS));
        // A whole number of metres (or cells, for scenes below a metre) keeps integers exact.
        let step = cell_m.max(1.0_f64.min(extent));
        let origin = (min / step).floor() * step;
        let mut grid = Self {
            origin,
            cell_m,
            vertices: HashMap::new(),
        };
        for p in points() {
            let cell = grid.to_cell(p);
            grid.vertices.entry((cell.x, cell.y)).or_insert(p);
        }
        Some(grid)
    }

    fn to_cell(&self, p: DVec2) -> IntPoint<i64> {
        let c = ((p - self.origin) / self.cell_m).round();
        IntPoint::new(c.x as i64, c.y as i64)
    }

    fn to_metres(&self, p: IntPoint<i64>) -> DVec2 {
        self.vertices
            .get(&(p.x, p.y))
            .copied()
            .unwrap_or_else(|| self.origin + DVec2::new(p.x as f64, p.y as f64) * self.cell_m)
    }

    /// One building as contours without self-intersection: all that its outer ring winds
    /// around, less its courtyards.
    fn resolve(&self, rings: &[Ring]) -> Vec<Contour> {
        let mut overlay = keeping_collinear(rings.iter().map(|r| r.points.len()).sum());
        for (i, ring) in rings.iter().enumerate() {
            let contour: Contour = ring.points.iter().map(|&p| self.to_cell(p)).collect();
            let role = if i == 0 {
                ShapeType::Subject
            } else {
                ShapeType::Clip
            };
            overlay.add_contour(&contour, role);
        }
        let shapes = overlay.overlay(OverlayRule::Difference, FillRule::NonZero);
        shapes.into_iter().flatten().collect()
    }

    /// Names each edge's building, joins flush walls of one material and starts the ring at its
    /// lowest, then leftmost vertex. `None` when rounding left no area.
    fn outline(
        &self,
        points: Vec<DVec2>,
        edges: &InputEdges,
        same_material: &impl Fn(usize, usize) -> bool,
    ) -> Option<Outline> {
        let tolerance = TOLERANCE_CELLS * self.cell_m;
        let n = points.len();
        let mut ring: Vec<(DVec2, usize)> = (0..n)
            .map(|i| {
                let building = edges.owner(points[i], points[(i + 1) % n], tolerance);
                (points[i], building)
            })
            .collect();
        let mut i = 0;
        let mut unchanged = 0;
        while ring.len() >= 3 && unchanged < ring.len() {
            let n = ring.len();
            i %= n;
            let (previous, owner_before) = ring[(i + n - 1) % n];
            let (here, owner) = ring[i];
            let next = ring[(i + 1) % n].0;
            let cell = self.to_cell(here);
            let is_input = self.vertices.contains_key(&(cell.x, cell.y));
            let bend = orient(previous, here, next);
            let flat =
                bend == 0.0 || (!is_input && bend.abs() <= tolerance * previous.distance(next));
            if here == previous || (flat && same_material(owner_before, owner)) {
                ring.remove(i);
                i = (i + ring.len() - 1) % ring.len();
                unchanged = 0;
            } else {
                i += 1;
                unchanged += 1;
            }
        }
        if ring.len() < 3 {
            return None;
        }
        let first = (0..ring.len())
            .min_by(|&p, &q| {
                let key = |i: usize| (ring[i].0.y, ring[i].0.x);
                key(p).partial_cmp(&key(q)).expect("coordinates are finite")
            })
            .unwrap_or(0);
        ring.rotate_left(first);
        let (points, edge_building) = ring.into_iter().unzip();
        Some(Outline {
            points,
            edge_building,
        })
    }
}

/// All edges of the input, to find out whose wall an edge of the union is.
struct InputEdges {
    edges: Vec<(DVec2, DVec2, usize)>,
    bvh: Bvh,
}

impl InputEdges {
    fn new(buildings: &[(usize, Vec<Ring>)]) -> Self {
        let mut edges = Vec::new();
        for (building, rings) in buildings {
            for Ring { points, .. } in rings {
                let n = points.len();
                edges.extend((0..n).map(|i| (points[i], points[(i + 1) % n], *building)));
            }
        }
        let boxes: Vec<Aabb> = edges
            .iter()
            .map(|&(a, b, _)| Aabb::new(a.min(b), a.max(b)))
            .collect();
        Self {
            bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
            edges,
        }
    }

    /// The lowest building with an edge along `a` to `b`, in the same sense if there is one.
    fn owner(&self, a: DVec2, b: DVec2, tolerance: f64) -> usize {
        let middle = a.midpoint(b);
        let around = Aabb::new(middle - tolerance, middle + tolerance);
        self.bvh
            .intersect_aabb(&around)
            .map(|i| self.edges[i as usize])
            .filter(|&(p, q, _)| (q - p).perp_dot(middle - p).abs() <= tolerance * p.distance(q))
            .min_by_key(|&(p, q, building)| ((q - p).dot(b - a) <= 0.0, building))
            .map_or(0, |(_, _, building)| building)
    }
}
