//! Settings of the scenes made from maps, and the size that a building has at least.

use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Area, Footprint, SceneConfig};
use serde::{Deserialize, Serialize};

use crate::error::Result;

/// A map needs a building as large as this [m].
pub const MIN_BUILDING_M: f64 = 1.0;

/// Settings of the scenes made from maps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSettings {
    /// Slits between walls that are narrower are filled \[m\]; 0 leaves all open.
    pub close_gaps_m: f64,
    /// Orientations that each training map is taken in: the first so many of its quarter turns and their mirror images. Copy
    /// `k` of map `id` has the id `k * `[`COPY_STRIDE`](super::COPY_STRIDE)` + id`. 1, which manifests do not state, is the map alone.
    #[serde(default = "upright", skip_serializing_if = "is_upright")]
    pub orientations: u32,
}

fn upright() -> u32 {
    1
}

fn is_upright(orientations: &u32) -> bool {
    *orientations == upright()
}

impl Default for SceneSettings {
    fn default() -> Self {
        Self {
            close_gaps_m: SceneConfig::default().close_gaps_m,
            orientations: upright(),
        }
    }
}

impl SceneSettings {
    /// Makes a scene in the area of a map.
    ///
    /// # Errors
    /// Footprints that make no scene.
    pub fn scene(self, footprints: &[Footprint], area: Area) -> Result<Scene> {
        let config = SceneConfig {
            area: Some(area),
            close_gaps_m: self.close_gaps_m,
        };
        Ok(Scene::with_config(footprints, &config)?)
    }
}

/// Bounding box of some points.
pub fn bounds(points: &[DVec2]) -> (DVec2, DVec2) {
    let grow = |(min, max): (DVec2, DVec2), &p: &DVec2| (min.min(p), max.max(p));
    let none = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    points.iter().fold(none, grow)
}
