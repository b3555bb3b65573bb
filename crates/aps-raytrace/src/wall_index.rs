//! The index over the walls of a scene.
//!
//! parry's bounding volume hierarchy answers questions about shapes. The two that are asked millions of times, which walls a leg may
//! meet and which a view may hold, go to a tree of eight boxes a node, compared with a convex region all at once.

use glam::DVec2;
use multiversion::multiversion;
use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode, TraversalAction};
use smallvec::SmallVec;

use crate::scene::Wall;

/// Boxes grow by this part of the scene's size, far more than rounding can take away.
const BOX_MARGIN: f64 = 1e-9;

/// Boxes a node.
const LANES: usize = 8;

/// Bounds of the boxes of a node: the lower ones, then the upper ones, by axis.
#[derive(Debug, Clone)]
struct Node([[[f64; LANES]; 2]; 2]);

/// Half plane of all points whose product with `axis` is at least `limit`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HalfPlane {
    pub axis: DVec2,
    pub limit: f64,
}

/// A half plane for all lanes.
struct Side {
    /// Which bound of a box lies farthest inside, by axis.
    bound: [usize; 2],
    axis: [[f64; LANES]; 2],
    limit: [f64; LANES],
}

impl Side {
    fn new(HalfPlane { axis, limit }: HalfPlane) -> Self {
        Self {
            bound: [axis.x, axis.y].map(|x| usize::from(x > 0.0)),
            axis: [axis.x, axis.y].map(|x| [x; LANES]),
            limit: [limit; LANES],
        }
    }
}

/// Walls selected by a search.
pub(crate) type Selected = SmallVec<[u32; 64]>;

/// Bounding volume hierarchies over the walls of a scene.
#[derive(Debug, Clone)]
pub(crate) struct WallIndex {
    bvh: Bvh,
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
        let mut index = Self {
            bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
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
        boxes = order.iter().map(|&wall| boxes[wall as usize]).collect();
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
    pub fn select<const N: usize>(&self, region: [HalfPlane; N], out: &mut Selected) {
        out.clear();
        if !self.levels.is_empty() {
            select(&self.levels, &region.map(Side::new), out);
        }
        for place in out {
            *place = self.walls[*place as usize];
        }
    }
}

fn merged(boxes: &[Aabb]) -> Option<Aabb> {
    let all = boxes.iter().copied();
    all.reduce(|p, q| Aabb::new(p.mins.min(q.mins), p.maxs.max(q.maxs)))
}

impl Node {
    /// A node of up to eight boxes; the rest are inside out, in no half plane.
    fn new(boxes: &[Aabb]) -> Self {
        let mut bounds = [[[f64::MAX; LANES]; 2], [[f64::MIN; LANES]; 2]];
        for (i, b) in boxes.iter().enumerate() {
            for (bounds, corner) in bounds.iter_mut().zip([b.mins, b.maxs]) {
                bounds[0][i] = corner.x;
                bounds[1][i] = corner.y;
            }
        }
        Self(bounds)
    }

    /// A bit for each box that has a point in each of the half planes.
    #[inline(always)]
    fn meets(&self, region: &[Side]) -> u8 {
        let mut least = [f64::INFINITY; LANES];
        for side in region {
            let [x, y] = [0, 1].map(|axis| &self.0[side.bound[axis]][axis]);
            for i in 0..LANES {
                let above = side.axis[0][i] * x[i] + side.axis[1][i] * y[i] - side.limit[i];
                least[i] = if above < least[i] { above } else { least[i] };
            }
        }
        // Signs as integers, which compilers gather with vectors.
        let mut outside = 0;
        for (i, above) in least.into_iter().enumerate() {
            outside |= (above.to_bits() >> 63) << i;
        }
        !outside as u8
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn select(levels: &[Vec<Node>], region: &[Side], out: &mut Selected) {
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
