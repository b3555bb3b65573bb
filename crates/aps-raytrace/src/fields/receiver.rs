//! The rays of a receiver: where its fan of rays is at each unfolded range.

use std::cell::Cell;

use glam::DVec2;

use super::map::FieldMap;
use crate::scene::Scene;

/// A wall is met though the ray begins this far behind it \[m\]: points of reflection are rounded.
const BEHIND_M: f64 = 1e-9;

/// Samples of one receiver's rays in the order (bounces, sample, direction).
#[derive(Debug, Clone)]
pub struct ReceiverRays {
    /// In the fields' own coordinates.
    pub(super) place: DVec2,
    /// Corners in sight, with their distance \[m\].
    pub(super) corners: Vec<(u32, f64)>,
    /// Pixel of each sample; the one beyond the last outside of the grid, and where the ray has ended.
    pub(super) pixels: Vec<u32>,
    /// x, y, range
    pub(super) x_m: Vec<f32>,
    pub(super) y_m: Vec<f32>,
    pub(super) range_m: Vec<f32>,
    /// By (bounces, direction): unit vector, sum of cosines of incidence, cosine of the last.
    pub(super) units: Vec<[f32; 4]>,
    /// By (bounces, direction): whether the segment is there
    pub(super) valid: Vec<bool>,
    /// By (bounces, direction): start of the segment [m].
    pub(super) start_m: Vec<f32>,
}

impl ReceiverRays {
    pub(super) fn new(map: &FieldMap<'_>, position: DVec2) -> Self {
        let (fan, grid) = (map.fan(), map.local_grid());
        let place = position - map.origin();
        let (directions, outside) = (fan.directions, grid.pixels());
        let segments = (fan.max_bounces + 1) * directions;
        let count = segments * fan.samples;
        let mut rays = Self {
            place,
            corners: map.corners.in_sight(map.scene(), place),
            pixels: vec![outside as u32; count],
            x_m: vec![0.0; count],
            y_m: vec![0.0; count],
            range_m: vec![0.0; count],
            units: vec![[0.0; 4]; segments],
            valid: vec![false; segments],
            start_m: vec![0.0; segments],
        };
        let [low, high] = map.reach();
        for (direction, unit) in fan.unit_vectors().into_iter().enumerate() {
            let mut ray = Ray {
                from: place,
                unit,
                start_m: 0.0,
                wall: None,
            };
            let (mut sum, mut last) = (0.0, 0.0);
            for bounces in 0..=fan.max_bounces {
                let next = ray.next_wall(map.scene());
                // Where it leaves the grid.
                let edge = DVec2::select(ray.unit.cmpge(DVec2::ZERO), high, low);
                let to_edge = ((edge - ray.from) / ray.unit).min_element();
                let end_m = next.map_or(to_edge, |n| n.0.min(to_edge));
                let segment = bounces * directions + direction;
                rays.units[segment] = [ray.unit.x as f32, ray.unit.y as f32, sum as f32, last as f32];
                rays.start_m[segment] = ray.start_m as f32;
                if end_m > 0.0 {
                    rays.valid[segment] = true;
                    for k in 0..fan.samples {
                        let t = end_m * (k as f64 + 0.5) / fan.samples as f64;
                        let here = ray.from + ray.unit * t;
                        let at = (bounces * fan.samples + k) * directions + direction;
                        let pixel = grid.pixel_at(here).unwrap_or(outside);
                        let offset = here - grid.first_m;
                        rays.pixels[at] = pixel as u32;
                        rays.x_m[at] = offset.x as f32;
                        rays.y_m[at] = offset.y as f32;
                        rays.range_m[at] = (ray.start_m + t) as f32;
                    }
                }
                let Some((distance_m, wall)) = next else { break };
                let normal = map.scene().walls()[wall as usize].outward();
                last = -ray.unit.dot(normal) / normal.length();
                sum += last;
                ray.reflect(map.scene(), distance_m, wall);
            }
        }
        rays
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
