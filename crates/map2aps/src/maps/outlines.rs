//! Outlines of a scene's buildings, and their image.

use aps_data::{Raster, RasterGrid};
use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;

use crate::error::Result;

/// Draws the image of a scene's buildings.
///
/// # Errors
/// A grid that makes no image.
pub fn raster(scene: &Scene, grid: RasterGrid) -> Result<Raster> {
    Ok(Raster::of_outlines(&outlines(scene), grid)?)
}

/// Rings of a scene's buildings \[m\].
pub fn outlines(scene: &Scene) -> Vec<Vec<[f64; 2]>> {
    let ring = |ring: &Vec<DVec2>| ring.iter().map(DVec2::to_array).collect();
    scene.outlines().iter().map(ring).collect()
}
