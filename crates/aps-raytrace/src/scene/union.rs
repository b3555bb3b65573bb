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

use super::gaps::{self, Edge, Filling};
use super::repair::{RepairKind, RepairReport};
use super::ring::{self, Ring};
use crate::predicates::orient;

type Contour = Vec<IntPoint<i64>>;

/// Cells along the scene's longer side, as a power of two.
const GRID_BITS: i32 = 40;
/// Largest distance, in cells, by which rounding of crossings may bend an edge.
const TOLERANCE_CELLS: f64 = 8.0;
/// Depth, in cells, to which the filling of a slit reaches into the walls on its sides.
const OVERLAP_CELLS: f64 = 4096.0;
/// Largest courtyard, in squares of the width of slits, that is dropped where slits were filled.
const VOID_WIDTHS: f64 = 4.0;

/// One closed outline of the union: interior to the left of every edge.
pub(super) struct Outline {
    /// Vertices \[m\].
    pub points: Vec<DVec2>,
    /// Building that the edge starting at each vertex belongs to.
    pub edge_building: Vec<usize>,
}

/// Unites cleaned buildings (outer ring counter-clockwise, holes clockwise) and closes slits narrower than `close_gaps_m`
/// between them.
///
/// `same_material` tells if flush walls of two buildings may become one.
pub(super) fn unite(
    buildings: &[(usize, Vec<Ring>)],
    close_gaps_m: f64,
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
            if contours.is_empty() {
                report.push(*building, RepairKind::Sliver);
            }
            !contours.is_empty()
        })
        .collect();
    report_contacts(&shapes, report);

    let mut edges = Vec::new();
    for (building, rings) in buildings {
        for ring in rings {
            add_edges(&mut edges, &ring.points, |_| *building);
        }
    }
    let contours = united(shapes.iter().flat_map(|(_, contours)| contours));
    let outlines = grid.outlines(&contours, &InputEdges::new(edges.clone()), &same_material);

    let mut walls = Vec::new();
    for outline in &outlines {
        add_edges(&mut walls, &outline.points, |i| outline.edge_building[i]);
    }
    let overlap_m = OVERLAP_CELLS * grid.cell_m;
    let fillings = gaps::fillings(&walls, close_gaps_m, overlap_m);
    if fillings.is_empty() {
        return outlines;
    }
    let mut closed: Vec<[usize; 2]> = fillings.iter().map(|f| f.buildings).collect();
    closed.sort_unstable();
    closed.dedup();
    for [building, other] in closed {
        report.push(building, RepairKind::Gap { other });
    }
    let of_filling = |filling: &Filling| filling.points.iter().map(|&p| grid.to_cell(p)).collect();
    let filled: Vec<Contour> = fillings.iter().map(of_filling).collect();
    for filling in &fillings {
        add_edges(&mut edges, &filling.points, |_| filling.buildings[0]);
    }
    let contours = united(contours.iter().chain(&filled));
    let mut outlines = grid.outlines(&contours, &InputEdges::new(edges), &same_material);
    // A small hole that fillings leave open between them is no courtyard.
    let void_m2 = VOID_WIDTHS * close_gaps_m * close_gaps_m;
    outlines.retain(|o| {
        let area_m2 = ring::doubled_area(&o.points) / 2.0;
        area_m2 > 0.0 || area_m2 < -void_m2
    });
    outlines
}

/// Appends the edges of a closed ring.
fn add_edges(edges: &mut Vec<Edge>, points: &[DVec2], building: impl Fn(usize) -> usize) {
    let (first, n) = (edges.len(), points.len());
    edges.extend((0..n).map(|i| Edge {
        a: points[i],
        b: points[(i + 1) % n],
        building: building(i),
        next: first + (i + 1) % n,
    }));
}

/// The union of contours without self-intersection, outer ones counter-clockwise.
fn united<'a>(contours: impl Iterator<Item = &'a Contour>) -> Vec<Contour> {
    let contours: Vec<&Contour> = contours.collect();
    let mut overlay = keeping_collinear(contours.iter().map(|c| c.len()).sum());
    for contour in contours {
        overlay.add_contour(contour, ShapeType::Subject);
    }
    let shapes = overlay.overlay(OverlayRule::Subject, FillRule::NonZero);
    shapes.into_iter().flatten().collect()
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
            if is_courtyard_filled(contours, &shapes[j].1) {
                report.push(*building, RepairKind::CourtyardFilled { by: other });
            } else if is_courtyard_filled(&shapes[j].1, contours) {
                report.push(other, RepairKind::CourtyardFilled { by: *building });
            }
        }
    }
}

/// Tells if a building is just what a courtyard of another one leaves open.
fn is_courtyard_filled(around: &[Contour], filling: &[Contour]) -> bool {
    let [filling] = filling else { return false };
    let n = filling.len();
    let is_filled = |yard: &Contour| {
        let start = filling.iter().position(|p| yard.first() == Some(p));
        let is_reverse = |start: usize| (0..n).all(|i| yard[i] == filling[(start + n - i) % n]);
        yard.len() == n && start.is_some_and(is_reverse)
    };
    around.iter().any(is_filled)
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
        points().next()?;
        let (min, max) = ring::bounds(points());
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
            let role = match i {
                0 => ShapeType::Subject,
                _ => ShapeType::Clip,
            };
            overlay.add_contour(&contour, role);
        }
        let shapes = overlay.overlay(OverlayRule::Difference, FillRule::NonZero);
        shapes.into_iter().flatten().collect()
    }

    /// The outlines that contours on the grid stand for, in an order that does not depend on how they were computed.
    fn outlines(
        &self,
        contours: &[Contour],
        edges: &InputEdges,
        same_material: &impl Fn(usize, usize) -> bool,
    ) -> Vec<Outline> {
        let outline = |contour: &Contour| {
            let points = contour.iter().map(|&p| self.to_metres(p)).collect();
            self.outline(points, edges, same_material)
        };
        let mut outlines: Vec<Outline> = contours.iter().filter_map(outline).collect();
        outlines.sort_by(|p, q| ring::by_first_edge(&p.points, &q.points));
        outlines
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
        ring::prune(&mut ring, |before, &(here, owner), &(next, _)| {
            let &(previous, owner_before) = before;
            let cell = self.to_cell(here);
            let is_input = self.vertices.contains_key(&(cell.x, cell.y));
            let bend = orient(previous, here, next);
            let flat =
                bend == 0.0 || (!is_input && bend.abs() <= tolerance * previous.distance(next));
            here == previous || (flat && same_material(owner_before, owner))
        });
        if ring.len() < 3 {
            return None;
        }
        let first = (0..ring.len()).min_by(|&p, &q| ring::by_height(&ring[p].0, &ring[q].0));
        ring.rotate_left(first.unwrap_or(0));
        let (points, edge_building) = ring.into_iter().unzip();
        Some(Outline {
            points,
            edge_building,
        })
    }
}

/// Edges of the input, by which the building of each edge of the union is found.
struct InputEdges {
    edges: Vec<Edge>,
    bvh: Bvh,
}

impl InputEdges {
    fn new(edges: Vec<Edge>) -> Self {
        let boxes: Vec<Aabb> = edges.iter().map(|e| ring::edge_box(e.a, e.b)).collect();
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
            .filter(|e| {
                let height = (e.b - e.a).perp_dot(middle - e.a).abs();
                height <= tolerance * e.a.distance(e.b)
            })
            .min_by_key(|e| ((e.b - e.a).dot(b - a) <= 0.0, e.building))
            .map_or(0, |e| e.building)
    }
}
