//! The index over the walls of a scene.
//!
//! parry's bounding volume hierarchy answers questions about shapes. The two that are asked millions of times, which walls a leg may
//! meet and which a view may hold, go to a tree of sixteen boxes a node, compared with a convex region all at once. Its boxes are in
//! single precision and compared with a region that is wider by its rounding: a few walls more than needed are selected, never one less.

use glam::DVec2;
use multiversion::multiversion;
use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode, TraversalAction};
use smallvec::SmallVec;

use crate::scene::Wall;

/// Boxes grow by this part of the scene's size, far more than rounding can take away.
const BOX_MARGIN: f64 = 1e-9;

/// Boxes a node.
const LANES: usize = 16;

/// Bounds of the boxes of a node around the centre of all: the lower ones, then the upper ones, by axis.
#[derive(Debug, Clone)]
struct Node([[[f32; LANES]; 2]; 2]);

/// Half plane of all points whose product with `axis` is at least `limit`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HalfPlane {
    pub axis: DVec2,
    pub limit: f64,
}

/// A half plane around the centre of all boxes, in single precision; it holds all of the one that it was made of.
#[derive(Debug, Clone, Copy)]
struct Rounded {
    axis: [f32; 2],
    limit: f32,
}

/// Part of its two terms that rounding may take from a sum in [`Node::meets`], in halves of a unit in the last place: one each for the
/// bounds of boxes, the axis and the products, three for taking away a limit of up to twice the terms (beyond that no sign is in
/// doubt), and one to spare. A sum of two keeps its sign.
const ROUNDING: f64 = 7.0 / (1 << 24) as f64;

/// Walls selected by a search.
pub(crate) type Selected = SmallVec<[u32; 64]>;

/// Bounding volume hierarchies over the walls of a scene.
#[derive(Debug, Clone)]
pub(crate) struct WallIndex {
    bvh: Bvh,
    /// Centre of all boxes, and the largest coordinate of one around it.
    centre: DVec2,
    reach: f64,
    /// Walls, neighbours side by side.
    walls: Vec<u32>,
    /// The boxes of `walls`, then of each level those of the nodes below, up to a single node.
    levels: Vec<Vec<Node>>,
}

impl WallIndex {
    pub fn new(walls: &[Wall]) -> Self {
        let extent = walls
            .iter()
            .map(|w| w.a.abs().max(w.b.abs()).max_element())
            .fold(0.0, f64::max);
        let margin = extent * BOX_MARGIN;
        let mut boxes: Vec<Aabb> = walls
            .iter()
            .map(|w| Aabb::new(w.a.min(w.b) - margin, w.a.max(w.b) + margin))
            .collect();
        let all = merged(&boxes).unwrap_or(Aabb::new(DVec2::ZERO, DVec2::ZERO));
        let centre = all.center();
        let mut index = Self {
            bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
            centre,
            reach: all.half_extents().max_element(),
            walls: Vec::new(),
            levels: Vec::new(),
        };
        let mut order = Vec::with_capacity(walls.len());
        index.for_each(
            |_, _| true,
            |wall| {
                order.push(wall);
                true
            },
        );
        boxes = order
            .iter()
            .map(|&wall| boxes[wall as usize])
            .map(|b| Aabb::new(b.mins - centre, b.maxs - centre))
            .collect();
        index.walls = order;
        while index.levels.last().is_none_or(|level| level.len() > 1) {
            let level: Vec<Node> = boxes.chunks(LANES).map(Node::new).collect();
            boxes = boxes.chunks(LANES).filter_map(merged).collect();
            if level.is_empty() {
                break;
            }
            index.levels.push(level);
        }
        index
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

    /// Selects the walls whose boxes have a point in each of the half planes.
    pub fn select<const PLANES: usize>(&self, region: &[HalfPlane; PLANES], out: &mut Selected) {
        out.clear();
        if !self.levels.is_empty() {
            let region = region.each_ref().map(|half| self.rounded(half));
            select(&self.levels, &region, out);
        }
        for place in out {
            *place = self.walls[*place as usize];
        }
    }

    /// Rounds a half plane so that no box in it is found outside. Its axis is scaled: single precision knows no number below 1e-45.
    #[inline]
    fn rounded(&self, &HalfPlane { axis, limit }: &HalfPlane) -> Rounded {
        let largest = axis.abs().max_element();
        let scale = if largest.is_normal() {
            1.0 / largest
        } else {
            1.0
        };
        let axis = axis * scale;
        let limit = limit * scale - axis.dot(self.centre);
        let slack = ROUNDING * self.reach * (axis.x.abs() + axis.y.abs());
        Rounded {
            axis: [axis.x as f32, axis.y as f32],
            limit: ((limit - slack) as f32).next_down(),
        }
    }
}

fn merged(boxes: &[Aabb]) -> Option<Aabb> {
    let all = boxes.iter().copied();
    all.reduce(|p, q| Aabb::new(p.mins.min(q.mins), p.maxs.max(q.maxs)))
}

impl Node {
    /// A node of up to so many boxes; the rest are inside out, in no half plane.
    fn new(boxes: &[Aabb]) -> Self {
        let mut bounds = [[[f32::MAX; LANES]; 2], [[f32::MIN; LANES]; 2]];
        for (i, b) in boxes.iter().enumerate() {
            for (bounds, corner) in bounds.iter_mut().zip([b.mins, b.maxs]) {
                bounds[0][i] = corner.x as f32;
                bounds[1][i] = corner.y as f32;
            }
        }
        Self(bounds)
    }

    /// A bit for each box that has a point in each of the half planes.
    #[inline(always)]
    fn meets<const PLANES: usize>(&self, region: &[Rounded; PLANES]) -> u16 {
        let mut least = [f32::INFINITY; LANES];
        for &Rounded { axis, limit } in region {
            // The bounds of a box that lie farthest inside.
            let x = &self.0[usize::from(axis[0] > 0.0)][0];
            let y = &self.0[usize::from(axis[1] > 0.0)][1];
            // Taking the limit from one product alone, compilers keep both apart and load them as they lie.
            for ((least, x), y) in least.iter_mut().zip(x).zip(y) {
                let above = (axis[0] * x - limit) + axis[1] * y;
                *least = if above < *least { above } else { *least };
            }
        }
        // Signs as integers, which compilers gather with vectors.
        let mut outside = 0;
        for (i, above) in least.into_iter().enumerate() {
            outside |= (above.to_bits() >> 31) << i;
        }
        !outside as u16
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn select<const PLANES: usize>(
    levels: &[Vec<Node>],
    region: &[Rounded; PLANES],
    out: &mut Selected,
) {
    let mut open: SmallVec<[(u32, u32); 64]> = SmallVec::new();
    open.push((levels.len() as u32 - 1, 0));
    while let Some((level, node)) = open.pop() {
        let mut bits = levels[level as usize][node as usize].meets(region);
        while bits != 0 {
            let place = node * LANES as u32 + bits.trailing_zeros();
            bits &= bits - 1;
            match level.checked_sub(1) {
                Some(below) => open.push((below, place)),
                None => out.push(place),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{CityConfig, Footprint, Scene};

    #[test]
    fn every_wall_with_an_end_in_the_region_is_selected() {
        let city = CityConfig {
            size_m: 400,
            ..CityConfig::default()
        };
        let scene = Scene::synthetic(&city).unwrap();
        let walls = scene.walls();
        assert!(walls.len() > LANES * LANES, "{}", walls.len());
        let mut selected = Selected::new();
        let mut counts = Vec::new();
        for i in 0..200 {
            let at = DVec2::new(f64::from(i * 37 % 401), f64::from(i * 91 % 397));
            let axis = DVec2::from_angle(f64::from(i));
            let region = [axis, axis.rotate(DVec2::from_angle(2.5))];
            let region = region.map(|axis: DVec2| HalfPlane {
                axis,
                limit: axis.dot(at),
            });
            scene.index().select(&region, &mut selected);
            selected.sort_unstable();
            let is_in = |p: DVec2| region.iter().all(|half| half.axis.dot(p) >= half.limit);
            for (id, wall) in (0..).zip(walls) {
                let is_selected = selected.binary_search(&id).is_ok();
                assert!(
                    is_selected || !(is_in(wall.a) || is_in(wall.b)),
                    "wall {id}"
                );
            }
            counts.push(selected.len());
        }
        assert!(counts.iter().all(|&count| count < walls.len()));
        assert!(counts.iter().any(|&count| count < walls.len() / 4));
    }

    #[test]
    fn walls_that_end_on_a_border_are_selected_far_from_the_origin_and_for_any_length_of_the_axis()
    {
        let ring = [(0.0, 0.0), (40.0, 0.0), (47.0, 31.0), (3.0, 22.0)];
        for far in [0.0, 3e5, 7e6] {
            let footprints: Vec<Footprint> = (0..400)
                .map(|n| DVec2::new(f64::from(n % 20), f64::from(n / 20)) * 64.0)
                .map(|place| {
                    ring.map(|(x, y)| place + DVec2::new(far + x, y - far))
                        .to_vec()
                })
                .map(Footprint::new)
                .collect();
            let scene = Scene::new(&footprints, None).unwrap();
            let mut selected = Selected::new();
            for (id, wall) in (0..).zip(scene.walls()) {
                for length in [1e-60, 1.0, 1e60] {
                    let axis = DVec2::from_angle(f64::from(id) * 0.7) * length;
                    let ends = [wall.a, wall.b].map(|end| axis.dot(end));
                    let limit = ends[0].max(ends[1]);
                    let half = HalfPlane { axis, limit };
                    scene.index().select(&[half], &mut selected);
                    assert!(selected.contains(&id), "wall {id} of a scene at {far} m");
                }
            }
        }
    }
}
