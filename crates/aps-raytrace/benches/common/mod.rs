//! Places for terminals, the same for all benchmarks.

use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Location;

/// Scattered outdoor places on whole metres.
pub fn outdoor(scene: &Scene, count: usize) -> Vec<DVec2> {
    (0..)
        .map(|i: u32| {
            let j = i.wrapping_mul(2_654_435_761) >> 9;
            DVec2::new(f64::from(j % 257), f64::from(j / 257 % 257))
        })
        .filter(|&p| scene.locate(p) == Location::Outdoor)
        .take(count)
        .collect()
}
