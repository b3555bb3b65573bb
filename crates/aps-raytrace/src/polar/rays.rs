//! The rays of a receiver: where they go, and which corners they pass.

use std::cell::Cell;

use glam::{DVec2, Vec2};
use multiversion::multiversion;

use super::corners::NO_CORNER;
use super::error::PolarError;
use super::fan::Fan;
use super::map::PolarMap;
use crate::scene::Scene;

/// Distance behind a wall \[m\] from which a ray still meets it: points of reflection are rounded.
const BEHIND_M: f64 = 1e-9;

/// Relative shortening of a ray before a wall, far above rounding.
const SHORTER: f64 = 1e-9;

/// A straight piece of a ray.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Segment {
    pub from: DVec2,
    pub unit: DVec2,
    /// Unfolded distance from the receiver at which it begins \[m\].
    pub start_m: f64,
    /// Length \[m\]: zero if the ray has ended before, infinite if it meets no wall.
    pub length_m: f64,
    /// Sum of the cosines of incidence at the walls before, and the last of them.
    pub cosines: [f32; 2],
}

impl Segment {
    /// Locates a place beside the segment: its unfolded distance \[m\], and the tangent of the angle from the ray to it, as the
    /// receiver sees it, counter-clockwise on this segment. `None` if the tangent is not below `beam_rad`, if the place lies before
    /// the segment's beginning or behind its end, or if something stands between it and its foot.
    ///
    /// Walls of `hiding` are tried first: they change the time that it takes, not the result.
    pub fn passes(
        &self,
        scene: &Scene,
        place: DVec2,
        beam_rad: f64,
        hiding: &[Option<u32>],
    ) -> Option<[f64; 2]> {
        if !self.is_beside(place, beam_rad) {
            return None;
        }
        let [along, across] = self.project(place);
        let foot_m = self.start_m + along;
        // The foot may lie on the wall that the segment ends at.
        let foot = self.from + self.unit * (along * (1.0 - SHORTER));
        let is_hiding = |&wall: &Option<u32>| scene.is_blocked_by(foot, place, wall);
        let is_blocked = || hiding.iter().any(is_hiding) || scene.is_blocked(foot, place);
        let is_free = foot == place || !is_blocked();
        is_free.then_some([foot_m.hypot(across), across / foot_m])
    }

    /// Locates an end of the wall that the segment ends at, as [`Segment::passes`] does, where the segment ends before it is abreast of
    /// it: the place is then seen along the wall. `None` in all other cases.
    fn stops_before(&self, scene: &Scene, place: DVec2, beam_rad: f64) -> Option<[f64; 2]> {
        let [along, across] = self.project(place);
        let foot_m = self.start_m + along;
        if !(along > self.length_m && across.abs() < beam_rad * foot_m) {
            return None;
        }
        let met = self.from + self.unit * (self.length_m * (1.0 - SHORTER));
        let is_free = !scene.is_blocked(met, place);
        is_free.then_some([foot_m.hypot(across), across / foot_m])
    }

    /// Computes how far along the segment, and how far to its left, a place lies \[m\].
    #[inline(always)]
    fn project(&self, place: DVec2) -> [f64; 2] {
        let r = place - self.from;
        [r.dot(self.unit), self.unit.perp_dot(r)]
    }

    /// Tells if a place lies beside the segment, whatever stands between.
    #[inline(always)]
    fn is_beside(&self, place: DVec2, beam_rad: f64) -> bool {
        let [along, across] = self.project(place);
        let widest = beam_rad * (self.start_m + along);
        (along > 0.0) & (along <= self.length_m) & (across.abs() < widest)
    }

    /// Unit vector to a place beside it from the receiver, or from its image behind the walls before.
    fn towards(&self, tangent: f64) -> Vec2 {
        (self.unit + self.unit.perp() * tangent)
            .normalize()
            .as_vec2()
    }
}

/// A corner that a ray passes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passed {
    pub corner: u32,
    /// Unfolded distance \[m\].
    pub range_m: f32,
    /// Tangent of the angle from the ray to it: see [`Segment::passes`].
    pub tangent: f32,
    /// Unit vector to it from the receiver, or from its image where the ray was reflected.
    pub ahead: Vec2,
}

impl Passed {
    /// A corner at a distance \[m\] and a tangent beside a segment.
    fn at(segment: &Segment, corner: u32, [range_m, tangent]: [f64; 2]) -> Self {
        Self {
            corner,
            range_m: range_m as f32,
            tangent: tangent as f32,
            ahead: segment.towards(tangent),
        }
    }
}

/// The rays of one receiver, and the corners that they pass; those at the ends of a wall that a ray meets before it is abreast of
/// them are among these.
///
/// A ray goes straight, and behind a wall along the reflected ray, up to the number of bounces of its [`super::Fan`]. Which wall
/// it meets is decided in floating point: a ray through a corner takes either side.
#[derive(Debug, Clone)]
pub struct ReceiverRays {
    /// Identifier of the map that prepared it.
    pub(super) map: u64,
    /// Position in the local scene \[m\].
    pub(super) place: DVec2,
    /// Segments in the order of bounces, then directions.
    pub(super) segments: Vec<Segment>,
    /// First and end index in `passed` of each segment's corners.
    first: Vec<u32>,
    passed: Vec<Passed>,
}

impl PolarMap<'_> {
    /// Follows the rays of a receiver.
    ///
    /// # Errors
    /// [`PolarError::Terminal`] where none can stand.
    pub fn receiver(&self, position: DVec2) -> Result<ReceiverRays, PolarError> {
        Ok(ReceiverRays::new(self, self.place(position)?))
    }
}

impl ReceiverRays {
    fn new(map: &PolarMap<'_>, place: DVec2) -> Self {
        let (fan, scene, corners) = (map.fan(), map.scene.local(), &map.corners);
        let mut segments = vec![Segment::default(); fan.pieces()];
        // By segment: the wall that it ends at.
        let mut walls = vec![None; fan.pieces()];
        for (direction, unit) in fan.unit_vectors().into_iter().enumerate() {
            let mut ray = Ray {
                from: place,
                unit,
                start_m: 0.0,
                wall: None,
            };
            let mut cosines = [0.0; 2];
            for bounces in 0..=fan.max_bounces {
                let next = ray.next_wall(scene);
                segments[bounces * fan.directions + direction] = Segment {
                    from: ray.from,
                    unit: ray.unit,
                    start_m: ray.start_m,
                    length_m: next.map_or(f64::INFINITY, |next| next.0),
                    cosines,
                };
                let Some((distance_m, wall)) = next else {
                    break;
                };
                walls[bounces * fan.directions + direction] = Some(wall);
                let outward = scene.walls()[wall as usize].outward().normalize();
                let cosine = -ray.unit.dot(outward) as f32;
                cosines = [cosines[0] + cosine, cosine];
                ray.reflect(scene, distance_m, wall);
            }
        }
        let mut first = Vec::with_capacity(segments.len() + 1);
        let mut passed = Vec::new();
        let mut near = vec![false; corners.corners.len()];
        for (i, segment) in segments.iter().enumerate() {
            first.push(passed.len() as u32);
            if segment.length_m <= 0.0 {
                continue;
            }
            are_near(segment, corners.columns(), fan.step_rad(), &mut near);
            let ends = walls[i].map_or([NO_CORNER; 2], |wall| corners.at_ends[wall as usize]);
            for corner in ends {
                let Some(found) = corners.corners.get(corner as usize) else {
                    continue;
                };
                let place = segment.stops_before(scene, found.point, fan.step_rad());
                passed.extend(place.map(|place| Passed::at(segment, corner, place)));
            }
            let places = (0..).zip(&near).filter(|(_, is_near)| **is_near);
            for (corner, _) in places {
                let at = corners.corners[corner as usize].point;
                // A wall that this ray or its neighbour meets often hides it.
                let hiding = neighbours(i, fan).map(|j| walls[j]);
                let place = segment.passes(scene, at, fan.step_rad(), &hiding);
                passed.extend(place.map(|place| Passed::at(segment, corner, place)));
            }
        }
        first.push(passed.len() as u32);
        Self {
            map: map.scene.id,
            place,
            segments,
            first,
            passed,
        }
    }

    /// The corners that a segment passes.
    #[inline]
    pub(super) fn passed(&self, segment: usize) -> &[Passed] {
        &self.passed[self.first[segment] as usize..self.first[segment + 1] as usize]
    }

    /// Memory that the rays take \[bytes\].
    #[must_use]
    pub fn bytes(&self) -> usize {
        let lists = size_of_val(&*self.segments) + size_of_val(&*self.first);
        lists + size_of_val(&*self.passed)
    }
}

/// Tells which places, by their columns, lie beside a segment.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn are_near(segment: &Segment, [x, y]: [&[f64]; 2], beam_rad: f64, out: &mut [bool]) {
    let (x, y) = (&x[..out.len()], &y[..out.len()]);
    for (i, out) in out.iter_mut().enumerate() {
        *out = segment.is_beside(DVec2::new(x[i], y[i]), beam_rad);
    }
}

/// Indices of a segment and of those in the neighbouring directions after as many bounces.
fn neighbours(segment: usize, fan: Fan) -> [usize; 3] {
    let n = fan.directions;
    let (start, direction) = (segment / n * n, segment % n);
    [0, 1, n - 1].map(|turn| start + (direction + turn) % n)
}

/// A ray on its way.
struct Ray {
    from: DVec2,
    unit: DVec2,
    /// Unfolded distance at which it begins \[m\].
    start_m: f64,
    /// The wall it was reflected at.
    wall: Option<u32>,
}

impl Ray {
    /// The first wall that the ray meets from the street, and the distance to it \[m\].
    fn next_wall(&self, scene: &Scene) -> Option<(f64, u32)> {
        let nearest = Cell::new((f64::INFINITY, u32::MAX));
        let (normal, inverse) = (self.unit.perp(), self.unit.recip());
        let meets_box = |centre: DVec2, extent: DVec2| {
            let r = centre - self.from;
            // Where the ray is between the box's sides, along each axis: -infinity to infinity if it runs along them.
            let (middle, half) = (r * inverse, (extent * inverse).abs());
            let from = (middle - half).max_element();
            let to = (middle + half).min_element();
            normal.dot(r).abs() <= normal.abs().dot(extent)
                && to >= -BEHIND_M
                && from <= nearest.get().0
        };
        scene.index().for_each(meets_box, |id| {
            let wall = &scene.walls()[id as usize];
            let (along, outward) = (wall.along(), wall.outward());
            let towards = -self.unit.dot(outward);
            if self.wall == Some(id) || towards <= 0.0 {
                return true;
            }
            let r = self.from - wall.a;
            let distance_m = r.dot(outward) / towards;
            let at = (r + self.unit * distance_m).dot(along);
            if distance_m >= -BEHIND_M && at >= 0.0 && at <= along.length_squared() {
                let met = (distance_m.max(0.0), id);
                if met < nearest.get() {
                    nearest.set(met);
                }
            }
            true
        });
        let (distance_m, id) = nearest.get();
        (id != u32::MAX).then_some((distance_m, id))
    }

    fn reflect(&mut self, scene: &Scene, distance_m: f64, wall: u32) {
        let normal = scene.walls()[wall as usize].outward();
        self.from += self.unit * distance_m;
        self.unit -= normal * (2.0 * self.unit.dot(normal) / normal.length_squared());
        self.start_m += distance_m;
        self.wall = Some(wall);
    }
}
