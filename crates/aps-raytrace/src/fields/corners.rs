//! Corners around which shortest ways bend, and what each sees: done once a map.
//!
//! A shortest way is a tight string: at each corner that it touches it bends around the building. So of the pairs of corners
//! that see each other only those count whose line passes the buildings at both ends, and from a corner only the part of the
//! view that the corner hides from the place the way comes from.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec2;
use rayon::prelude::*;

use super::canvas::{Canvas, HalfPlane, Source};
use super::error::FieldError;
use super::view::{Piece, Scratch, View};
use crate::images::Outlook;
use crate::material::Material;
use crate::predicates::orient;
use crate::scene::{Scene, Wall};

/// Largest memory for the views and pairs of a map's corners.
const MAX_BYTES: usize = 1 << 30;

/// Nearer to a wall's direction than this \[rad\] a ray is along it: far above rounding, far below what pixels tell apart.
const ALONG_RAD: f64 = 1e-9;

/// A corner that ways bend around: more than half of the plane around it is street.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    pub point: DVec2,
    /// Far end of the wall that starts here.
    first: DVec2,
    /// Far end of the wall on the other side of the street.
    last: DVec2,
}

impl Corner {
    /// Tells on which sides of the street's two walls a place lies: positive in front of them.
    fn sides(&self, p: DVec2) -> [f64; 2] {
        [
            -orient(self.point, self.first, p),
            -orient(self.last, self.point, p),
        ]
    }

    /// Tells if a tight string can come from a place and bend here: it lies before, or along, one of the walls but not before
    /// the other.
    pub fn bends(&self, from: DVec2) -> bool {
        let [first, last] = self.sides(from);
        (first > 0.0) != (last > 0.0) || (first == 0.0) != (last == 0.0)
    }

    /// The part of the plane that ways from a place reach around the corner only: between the straight way on and the wall
    /// that is hidden.
    fn shadow(&self, from: DVec2) -> [HalfPlane; 2] {
        let ahead = self.point - from;
        let [first, last] = self.sides(from);
        // Walls have the street to their right.
        let directions = match first >= 0.0 && last <= 0.0 {
            true => [-ahead, self.last - self.point],
            false => [ahead, self.point - self.first],
        };
        directions.map(|direction| HalfPlane {
            point: self.point,
            direction,
        })
    }

    /// Tells if some of a piece of the view is where a tight string may go on to.
    fn may_go_on_to(&self, piece: &Piece) -> bool {
        let rays = piece.far.map(|p| self.sides(p));
        // A string does not bend towards what lies before both walls.
        let is_before = rays.iter().flatten().all(|&side| side > 0.0);
        // Behind both, where the view is of the building's inside, a piece may end along one of them.
        let [first, last] = [self.first, self.last].map(|end| end.distance(self.point));
        let is_behind = piece.far.iter().zip(rays).all(|(p, sides)| {
            let slack = ALONG_RAD * p.distance(self.point);
            sides[0] <= slack * first && sides[1] <= slack * last
        });
        !is_before && !is_behind
    }
}

/// The corners of a map.
#[derive(Debug, Clone, Default)]
pub(super) struct Corners {
    pub corners: Vec<Corner>,
    /// By wall and end: the corner there, or [`u32::MAX`].
    pub at_end: Vec<[u32; 2]>,
    /// Pieces of each corner's view that a tight string may go on to.
    views: Vec<Vec<Piece>>,
    /// Corners that a tight string may go on to from each corner, with their distance \[m\].
    next: Vec<Vec<(u32, f64)>>,
}

impl Corners {
    /// Finds them, spread over the threads. Costs a view for each corner and a visibility test for each pair of corners before
    /// whose walls the other one lies on one side.
    pub fn new(scene: &Scene, reach: [DVec2; 2]) -> Result<Self, FieldError> {
        let corners = corners(scene);
        let bytes = AtomicUsize::new(0);
        // The order of counting does not change if there is too much.
        let take = |size: usize| bytes.fetch_add(size, Ordering::Relaxed) + size <= MAX_BYTES;
        let of_corner = |(scratch, outlook): &mut (Scratch, Outlook), near: &Corner| {
            let mut pieces = Vec::new();
            for view in View::around(near.point) {
                view.pieces(scene, reach, scratch, &mut pieces);
            }
            pieces.retain(|piece| near.may_go_on_to(piece));
            pieces.shrink_to_fit();
            if !take(size_of_val(&*pieces)) {
                pieces.clear();
            }
            outlook.look(scene, near.point);
            let is_next = |far: &Corner| near.bends(far.point) && far.bends(near.point);
            let next = in_sight(scene, &corners, near.point, outlook, is_next);
            let next = next.take_while(|_| take(size_of::<(u32, f64)>()));
            (pieces, next.collect())
        };
        let (views, next) = corners
            .par_iter()
            .map_init(Default::default, of_corner)
            .unzip();
        if bytes.into_inner() > MAX_BYTES {
            return Err(FieldError::TooManyCorners { limit: MAX_BYTES });
        }
        let at_end = scene.walls().iter().map(|wall| {
            [wall.a, wall.b].map(|end| {
                let at = corners.iter().position(|c: &Corner| c.point == end);
                at.map_or(u32::MAX, |at| at as u32)
            })
        });
        Ok(Self {
            at_end: at_end.collect(),
            corners,
            views,
            next,
        })
    }

    /// Corners in sight of a place that a tight string from there bends at, with their distance \[m\].
    pub fn in_sight(&self, scene: &Scene, from: DVec2) -> Vec<(u32, f64)> {
        let mut outlook = Outlook::default();
        outlook.look(scene, from);
        in_sight(scene, &self.corners, from, &outlook, |corner| {
            corner.bends(from)
        })
        .collect()
    }

    /// The shortest ways from a place to all corners that a tight string bends at.
    pub fn ways(&self, scene: &Scene, from: DVec2) -> Ways {
        let seeds = self.in_sight(scene, from).into_iter();
        self.ways_of(seeds.map(|(corner, length_m)| Seed {
            corner,
            length_m,
            from,
            cos_sum: 0.0,
        }))
    }

    /// The shortest ways that begin with the given ones (Dijkstra 1959).
    pub fn ways_of(&self, seeds: impl Iterator<Item = Seed>) -> Ways {
        let mut ways = Ways {
            lengths_m: vec![f64::INFINITY; self.corners.len()],
            before: vec![DVec2::ZERO; self.corners.len()],
            turned_rad: vec![0.0; self.corners.len()],
            count: vec![0; self.corners.len()],
            cos_sum: vec![0.0; self.corners.len()],
        };
        let mut heap = BinaryHeap::new();
        for seed in seeds {
            let c = seed.corner as usize;
            if seed.length_m < ways.lengths_m[c] {
                ways.lengths_m[c] = seed.length_m;
                ways.before[c] = seed.from;
                ways.count[c] = 1;
                ways.cos_sum[c] = seed.cos_sum;
                heap.push(Reverse(Entry(seed.length_m, seed.corner)));
            }
        }
        while let Some(Reverse(Entry(length_m, c))) = heap.pop() {
            if length_m > ways.lengths_m[c as usize] {
                continue;
            }
            for &(to, step_m) in &self.next[c as usize] {
                let length_m = length_m + step_m;
                if length_m < ways.lengths_m[to as usize] {
                    let here = self.corners[c as usize].point;
                    let there = self.corners[to as usize].point;
                    let turn_rad = (here - ways.before[c as usize]).angle_to(there - here).abs();
                    ways.lengths_m[to as usize] = length_m;
                    ways.before[to as usize] = here;
                    ways.turned_rad[to as usize] = ways.turned_rad[c as usize] + turn_rad;
                    ways.count[to as usize] = ways.count[c as usize].saturating_add(1);
                    ways.cos_sum[to as usize] = ways.cos_sum[c as usize];
                    heap.push(Reverse(Entry(length_m, to)));
                }
            }
        }
        ways
    }

    /// Paints the shadow of each corner that ways reach, as source `first_id` and the following.
    pub fn paint(&self, scene: &Scene, ways: &Ways, first_id: u32, canvas: &mut Canvas) {
        for (c, corner) in self.corners.iter().enumerate() {
            if ways.lengths_m[c].is_infinite() {
                continue;
            }
            let cuts = corner.shadow(ways.before[c]);
            let source = self.source(ways, c);
            let is_outside =
                |piece: &Piece, cut: &HalfPlane| piece.far.map(|p| cut.depth(p) < 0.0) == [true; 2];
            for piece in &self.views[c] {
                if !cuts.iter().any(|cut| is_outside(piece, cut)) {
                    let sides = piece.sides(scene, None).chain(cuts);
                    canvas.paint(piece.heights_m(), sides, first_id + c as u32, &source);
                }
            }
        }
    }

    /// A corner as a source of the ways over it.
    pub fn source(&self, ways: &Ways, corner: usize) -> Source {
        Source {
            point: self.corners[corner].point,
            offset_m: ways.lengths_m[corner],
        }
    }
}

/// The corners of a kind in sight of the place where `outlook` was taken, with their distance \[m\].
fn in_sight(
    scene: &Scene,
    corners: &[Corner],
    from: DVec2,
    outlook: &Outlook,
    is_of_kind: impl Fn(&Corner) -> bool,
) -> impl Iterator<Item = (u32, f64)> {
    let is_seen = move |to: DVec2| {
        !scene.is_blocked_by(from, to, outlook.nearest(to - from))
            && !scene.is_blocked(from, to, [None; 2])
    };
    let all = (0..).zip(corners);
    let seen = all.filter(move |(_, corner)| is_of_kind(corner) && is_seen(corner.point));
    seen.map(move |(c, corner)| (c, from.distance(corner.point)))
}

/// Shortest ways from one place to the corners.
#[derive(Debug, Clone)]
pub(super) struct Ways {
    /// Infinite where there is none \[m\].
    pub lengths_m: Vec<f64>,
    /// The place before each corner: the corner before, or where the ways begin.
    pub before: Vec<DVec2>,
    /// Angle by which the way has turned before the corner \[rad\].
    pub turned_rad: Vec<f64>,
    /// Corners of the way, this one included.
    pub count: Vec<u8>,
    /// Sum of the cosines of incidence of the reflections before.
    pub cos_sum: Vec<f64>,
}

/// A straight way to a corner, from a place or an image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seed {
    pub corner: u32,
    pub length_m: f64,
    pub from: DVec2,
    pub cos_sum: f64,
}

impl Ways {
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.lengths_m) + size_of_val(&*self.before)
    }
}

/// A way on the heap, ordered by length.
#[derive(Debug, PartialEq)]
struct Entry(f64, u32);

impl Eq for Entry {}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// The corners that diffract: ways bend around the same.
fn corners(scene: &Scene) -> Vec<Corner> {
    // The carrier and the walls' material say nothing about where corners are.
    let reflectors = vec![Material::PerfectConductor.at(1e9); scene.walls().len()];
    let wedges = scene.wedges(&reflectors, 1.0);
    let walls = scene.walls();
    let corner = |wedge: &crate::wedge::Wedge| {
        let first = &walls[wedge.id as usize];
        let ends_here = |wall: &&Wall| wall.b == wedge.point;
        let is_last = |wall: &&Wall| wedge.ray(wall.a).angles()[1] == 0.0;
        let previous = std::iter::once(&walls[first.previous as usize]);
        let last = previous.chain(walls).filter(ends_here).find(is_last);
        last.map(|last| Corner {
            point: wedge.point,
            first: first.b,
            last: last.a,
        })
    };
    wedges.iter().filter_map(corner).collect()
}
