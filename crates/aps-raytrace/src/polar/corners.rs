//! Corners that ways bend around, and the shortest ways between them: done once a map.
//!
//! A shortest way is a tight string: at each corner that it touches it bends around the building. So of the pairs of corners
//! that see each other only those count whose line passes the buildings at both ends.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec2;
use rayon::prelude::*;

use super::error::PolarError;
use crate::images::Visibility;
use crate::predicates::orient;
use crate::scene::Scene;

/// Largest memory for the pairs of a map's corners.
const MAX_BYTES: usize = 1 << 30;

/// Marker of an end of a wall without a corner.
pub(super) const NO_CORNER: u32 = u32::MAX;

/// A corner that ways bend around: more than half of the plane around it is street.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    pub point: DVec2,
    /// The wall that starts here, and its far end.
    first: (u32, DVec2),
    /// The wall on the other side of the street, and its far end.
    last: (u32, DVec2),
    /// Unit vector into the building, half-way between its two walls.
    pub inward: DVec2,
}

impl Corner {
    /// Tells if a tight string can come from a place and bend here: it lies before, or along, one of the walls but not before
    /// the other.
    pub fn bends(&self, from: DVec2) -> bool {
        let first = -orient(self.point, self.first.1, from);
        let last = -orient(self.last.1, self.point, from);
        (first > 0.0) != (last > 0.0) || (first == 0.0) != (last == 0.0)
    }
}

/// The corners of a map.
#[derive(Debug, Clone, Default)]
pub(super) struct Corners {
    pub corners: Vec<Corner>,
    /// Coordinates of the corners, x and y \[m\], so that one instruction takes several of them.
    columns: [Vec<f64>; 2],
    /// Corners at the start and the end of each wall, or [`NO_CORNER`].
    pub at_ends: Vec<[u32; 2]>,
    /// Corners that a tight string may go on to from each corner, with their distance \[m\].
    next: Vec<Vec<(u32, f64)>>,
}

impl Corners {
    /// Finds the corners, spread over the threads.
    pub fn new(scene: &Scene) -> Result<Self, PolarError> {
        let corners = corners(scene);
        let mut at_ends = vec![[NO_CORNER; 2]; scene.walls().len()];
        for (c, corner) in (0..).zip(&corners) {
            at_ends[corner.first.0 as usize][0] = c;
            at_ends[corner.last.0 as usize][1] = c;
        }
        let bytes = AtomicUsize::new(0);
        // The order of counting does not change if there is too much.
        let take = |size: usize| bytes.fetch_add(size, Ordering::Relaxed) + size <= MAX_BYTES;
        let next_of = |visibility: &mut Visibility, near: &Corner| {
            visibility.look(scene, near.point);
            let is_next = |far: &Corner| near.bends(far.point) && far.bends(near.point);
            let next = in_sight(scene, &corners, visibility, is_next);
            next.take_while(|_| take(size_of::<(u32, f64)>())).collect()
        };
        let next = corners.par_iter().map_init(Visibility::default, next_of);
        let next = next.collect();
        if bytes.into_inner() > MAX_BYTES {
            return Err(PolarError::TooManyCorners { limit: MAX_BYTES });
        }
        let column = |axis: usize| corners.iter().map(|c| c.point[axis]).collect();
        Ok(Self {
            columns: [column(0), column(1)],
            corners,
            at_ends,
            next,
        })
    }

    /// Coordinates of the corners by axis \[m\].
    pub fn columns(&self) -> [&[f64]; 2] {
        self.columns.each_ref().map(Vec::as_slice)
    }

    /// Corners in sight of a place, with their distance \[m\].
    pub fn in_sight(&self, scene: &Scene, from: DVec2) -> Vec<(u32, f64)> {
        let visibility = Visibility::from(scene, from);
        in_sight(scene, &self.corners, &visibility, |_| true).collect()
    }

    /// Selects the corners in sight of a place that a tight string from there bends at.
    pub fn bending<'a>(
        &'a self,
        in_sight: &'a [(u32, f64)],
        from: DVec2,
    ) -> impl Iterator<Item = (u32, f64)> + 'a {
        let bends = move |(corner, _): &(u32, f64)| self.corners[*corner as usize].bends(from);
        in_sight.iter().copied().filter(bends)
    }

    /// The shortest tight strings from a place to the corners (Dijkstra 1959), given the corners in its sight.
    pub fn strings(&self, in_sight: &[(u32, f64)], from: DVec2) -> Vec<TightString> {
        let mut strings = vec![TightString::NONE; self.corners.len()];
        // By length: the bits of numbers that are not negative have their order.
        let mut heap = BinaryHeap::new();
        for (c, length_m) in self.bending(in_sight, from) {
            strings[c as usize] = TightString {
                length_m,
                before: from,
                turned_rad: 0.0,
                corners: 1,
            };
            heap.push(Reverse((length_m.to_bits(), c)));
        }
        while let Some(Reverse((length_bits, c))) = heap.pop() {
            let length_m = f64::from_bits(length_bits);
            let near = strings[c as usize];
            if length_m > near.length_m {
                continue;
            }
            let here = self.corners[c as usize].point;
            for &(to, step_m) in &self.next[c as usize] {
                let length_m = length_m + step_m;
                if length_m < strings[to as usize].length_m {
                    let ahead = self.corners[to as usize].point - here;
                    strings[to as usize] = TightString {
                        length_m,
                        before: here,
                        turned_rad: near.turned_rad + (here - near.before).angle_to(ahead).abs(),
                        corners: near.corners + 1,
                    };
                    heap.push(Reverse((length_m.to_bits(), to)));
                }
            }
        }
        strings
    }
}

/// The shortest way from a place to a corner around the buildings.
#[derive(Debug, Clone, Copy)]
pub(super) struct TightString {
    /// Length \[m\]; infinite where there is none.
    pub length_m: f64,
    /// The corner before, or where it begins.
    pub before: DVec2,
    /// Sum of the angles by which it has turned before the corner \[rad\].
    pub turned_rad: f64,
    /// Corners that it touches, this one included.
    pub corners: u32,
}

impl TightString {
    const NONE: Self = Self {
        length_m: f64::INFINITY,
        before: DVec2::ZERO,
        turned_rad: 0.0,
        corners: 0,
    };
}

/// The corners of a kind in sight of the place that `visibility` is of, with their distance \[m\].
fn in_sight(
    scene: &Scene,
    corners: &[Corner],
    visibility: &Visibility,
    is_of_kind: impl Fn(&Corner) -> bool,
) -> impl Iterator<Item = (u32, f64)> {
    let is_seen = move |corner: &Corner| visibility.sees(scene, corner.point);
    let all = (0..).zip(corners);
    let seen = all.filter(move |(_, corner)| is_of_kind(corner) && is_seen(corner));
    seen.map(move |(c, corner)| (c, visibility.from.distance(corner.point)))
}

/// Finds the corners that diffract: ways bend around the same.
fn corners(scene: &Scene) -> Vec<Corner> {
    let walls = scene.walls();
    let corner = |id: u32| {
        let last = scene.other_face(id)?;
        let point = walls[id as usize].a;
        let ends = [walls[id as usize].b, walls[last as usize].a];
        let [first_along, last_along] = ends.map(|end| (end - point).normalize_or_zero());
        Some(Corner {
            point,
            first: (id, ends[0]),
            last: (last, ends[1]),
            inward: (first_along + last_along).normalize_or_zero(),
        })
    };
    (0..walls.len() as u32).filter_map(corner).collect()
}
