//! Identity of the map that a data set keeps: a checksum of its buildings.

use aps_data::{Dataset, MapEntry, Raster, RasterGrid, npy, sha256_of};
use aps_raytrace::Scene;
use serde_json::{Map, Value, json};

use super::raster;
use crate::error::Result;

/// Name of the checksum in the statistics of a map.
pub(crate) const OUTLINES: &str = "outlines";

/// Name of the checksum of the files that an imported map is made of, in its statistics.
pub(crate) const SOURCE: &str = "source";

/// Computes the SHA-256 of the outlines of a scene's buildings, in whole millimetres. A city in degrees has the same on machines whose
/// sines differ in the last digit: its coordinates are rounded to parts of a metre before.
pub(crate) fn outlines_sha256(scene: &Scene) -> String {
    let mut bytes = Vec::new();
    for ring in scene.outlines() {
        bytes.extend((ring.len() as u64).to_le_bytes());
        for point in ring {
            for coordinate_m in point.to_array() {
                bytes.extend(((1e3 * coordinate_m).round() as i64).to_le_bytes());
            }
        }
    }
    sha256_of(&bytes)
}

/// Adds the checksum of its scene to the statistics of a map.
pub(crate) fn with_outlines(mut statistics: Value, scene: &Scene) -> Value {
    statistics[OUTLINES] = json!(outlines_sha256(scene));
    statistics
}

/// Tells if the statistics hold nothing but what a map is made of, as those of an import.
pub(crate) fn is_origin_alone(statistics: &Map<String, Value>) -> bool {
    let mut keys = statistics.keys();
    keys.all(|key| key == SOURCE || key == OUTLINES)
}

/// The checksum of its outlines that a map keeps, if it does.
pub(crate) fn stored_outlines(map: &MapEntry) -> Option<&str> {
    map.statistics[OUTLINES].as_str()
}

/// Compares a scene with the checksum that a map keeps of its buildings, or else with its image; returns the name of the one that differs.
///
/// # Errors
/// An image that cannot be drawn.
pub(crate) fn contradicted(
    map: &MapEntry,
    scene: &Scene,
    grid: RasterGrid,
) -> Result<Option<&'static str>> {
    if let Some(stored) = stored_outlines(map) {
        return Ok((stored != outlines_sha256(scene)).then_some(OUTLINES));
    }
    let (image, mut bytes) = (raster(scene, grid)?, Vec::new());
    npy::write_to(&mut bytes, &[grid.height, grid.width], image.pixels())?;
    let (name, sha256) = ("buildings.npy", sha256_of(&bytes));
    let mut files = map.files.iter();
    let is_other = files.any(|file| file.name == name && file.sha256 != sha256);
    Ok(is_other.then_some(name))
}

/// Buildings of a map as a data set keeps them.
#[derive(Debug, Clone)]
pub(crate) struct Kept {
    /// Image of the buildings.
    pub image: Raster,
    /// Checksum of their outlines; `None` in maps of earlier versions, and in those that came without outlines.
    pub outlines: Option<String>,
}

impl Kept {
    /// The buildings of a map with this image.
    pub fn new(dataset: &Dataset, id: u32, image: Raster) -> Self {
        let outlines = dataset.manifest().map(id).and_then(stored_outlines);
        Self {
            image,
            outlines: outlines.map(Into::into),
        }
    }

    /// Tells if they are those of a scene.
    ///
    /// # Errors
    /// An image that cannot be drawn.
    pub fn is_of(&self, scene: &Scene) -> Result<bool> {
        let outlines = self.outlines.as_ref();
        Ok(
            outlines.is_none_or(|stored| *stored == outlines_sha256(scene))
                && raster(scene, self.image.grid())? == self.image,
        )
    }

    /// Tells if the image shows no building, as that of a data set that came without maps.
    pub fn is_blank(&self) -> bool {
        self.image.pixels().iter().all(|&pixel| pixel == 0)
    }
}

#[cfg(test)]
mod tests {
    use aps_raytrace::scene::Area;

    use super::*;
    use crate::maps::SceneSettings;

    #[test]
    fn a_wall_that_moves_by_less_than_a_pixel_is_another_map() {
        let scene = |north_m: f64| {
            let text = format!("[[[40,40],[90,40],[90,{north_m}],[40,{north_m}]]]");
            let footprints = crate::maps::radiomapseer::footprints(text.as_bytes()).unwrap();
            SceneSettings::default()
                .scene(&footprints, Area::RADIOMAPSEER)
                .unwrap()
        };
        let sum = |north_m| outlines_sha256(&scene(north_m));
        assert_eq!(sum(80.0), sum(80.0 + 1e-9));
        assert_ne!(sum(80.0), sum(80.25));
        let grid = Default::default();
        let image = |north_m| raster(&scene(north_m), grid).unwrap();
        assert!(image(80.0) == image(80.25), "or an image would do");
    }
}
