//! The rays of a receiver: where its fan of rays is at each unfolded range.

use std::cell::Cell;

use glam::DVec2;

use super::map::FieldMap;
use crate::scene::Scene;

/// A wall is met though the ray begins this far behind it \[m\]: points of reflection are rounded.
const BEHIND_M: f64 = 1e-9;

/// Marks in [`ReceiverRays::marks`]: a corner is near. The lower bits count bounces.
pub(super) const NEAR_CORNER: u8 = 128;

/// Bounces of a position at which its ray has ended.
pub(super) const ENDED: u8 = 127;

/// The positions of one receiver's rays, in the order of ranges, then directions: 13 bytes each.
///
/// A ray goes straight, and behind a wall along the reflected ray, up to the number of bounces of its [`super::Fan`]. Which wall
/// it meets is decided in floating point: a ray through a corner takes either side.
#[derive(Debug, Clone)]
pub struct ReceiverRays {
    pub(super) position: DVec2,
    /// In the fields' own coordinates.
    pub(super) place: DVec2,
    /// Corners in sight, with their distance \[m\].
    pub(super) corners: Vec<(u32, f64)>,
    /// Pixel of each position; the one beyond the last outside of the grid, and where the ray has ended.
    pub(super) pixels: Vec<u32>,
    /// Places of the positions, counted from the first pixel \[m\].
    pub(super) x_m: Vec<f32>,
    pub(super) y_m: Vec<f32>,
    /// Bounces before the position, or [`ENDED`]; and [`NEAR_CORNER`].
    pub(super) marks: Vec<u8>,
}

/// A position on a ray of a receiver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Place \[m\], to some 1e-7 of the grid's extent.
    pub position: DVec2,
    /// Unfolded distance from the receiver \[m\].
    pub range_m: f64,
    /// Reflections on the way there.
    pub bounces: usize,
    /// True beyond the edge of the grid, where there are no fields.
    pub is_outside: bool,
}

impl ReceiverRays {
    pub(super) fn new(map: &FieldMap<'_>, position: DVec2) -> Self {
        let (fan, grid) = (map.fan(), map.local_grid());
        let place = position - map.origin();
        let (directions, outside) = (fan.directions, grid.pixels());
        let mut rays = Self {
            position,
            place,
            corners: map.corners.in_sight(map.scene(), place),
            pixels: vec![outside as u32; fan.positions()],
            x_m: vec![0.0; fan.positions()],
            y_m: vec![0.0; fan.positions()],
            marks: vec![ENDED; fan.positions()],
        };
        for (direction, unit) in fan.unit_vectors().into_iter().enumerate() {
            let mut ray = Ray {
                from: place,
                unit,
                start_m: 0.0,
                wall: None,
            };
            let mut next = ray.next_wall(map.scene());
            let mut bounces = 0;
            for (row, &range_m) in fan.ranges_m.iter().enumerate() {
                while let Some((distance_m, wall)) = next
                    && range_m >= ray.start_m + distance_m
                    && bounces <= fan.max_bounces
                {
                    ray.reflect(map.scene(), distance_m, wall);
                    bounces += 1;
                    next = ray.next_wall(map.scene());
                }
                if bounces > fan.max_bounces {
                    break;
                }
                let at = row * directions + direction;
                let here = ray.from + ray.unit * (range_m - ray.start_m);
                let pixel = grid.pixel_at(here).unwrap_or(outside);
                let offset = here - grid.first_m;
                rays.pixels[at] = pixel as u32;
                rays.x_m[at] = offset.x as f32;
                rays.y_m[at] = offset.y as f32;
                let is_near = map.near_corner.get(pixel).is_some_and(|&is_near| is_near);
                rays.marks[at] = bounces as u8 | if is_near { NEAR_CORNER } else { 0 };
            }
        }
        rays
    }

    /// Position of the receiver \[m\].
    #[must_use]
    pub fn position(&self) -> DVec2 {
        self.position
    }

    /// Memory they take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.pixels.len() * 13 + size_of_val(&*self.corners)
    }

    /// Returns the position at a range of a ray, by their indices; `None` where the ray has ended at a wall.
    ///
    /// # Panics
    /// When there is no such range or direction.
    #[must_use]
    pub fn sample(&self, map: &FieldMap<'_>, range: usize, direction: usize) -> Option<Sample> {
        let (fan, grid) = (map.fan(), map.grid());
        assert!(
            direction < fan.directions,
            "there is no direction {direction}"
        );
        let at = range * fan.directions + direction;
        let bounces = self.marks[at] & !NEAR_CORNER;
        (bounces != ENDED).then(|| Sample {
            position: grid.first_m + DVec2::new(self.x_m[at].into(), self.y_m[at].into()),
            range_m: fan.ranges_m[range],
            bounces: bounces.into(),
            is_outside: self.pixels[at] as usize == grid.pixels(),
        })
    }
}

/// A straight piece of a ray.
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
