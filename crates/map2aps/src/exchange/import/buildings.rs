//! The buildings of an imported map.

use std::path::PathBuf;

use aps_data::{Raster, RasterGrid};
use aps_raytrace::Scene;
use aps_raytrace::glam::{DVec2, dvec2};
use aps_raytrace::scene::Location;

use super::ExchangeError;
use crate::error::Result;
use crate::maps::{self, MapSource, SceneSettings};

/// Places are whole metres in names: an end that seems to be this far inside a building may stand outside \[m\].
const MARGIN_M: f64 = 1.0;

/// The buildings of a map: drawn from its footprints, or none where no maps are given.
pub(super) struct Buildings {
    pub image: Raster,
    /// The scene, and the file that it is of.
    scene: Option<(Scene, PathBuf)>,
}

impl Buildings {
    pub fn of(maps: Option<&MapSource>, id: u32) -> Result<Self> {
        let Some(maps) = maps else {
            let image = Raster::empty(RasterGrid::default())?;
            return Ok(Self { image, scene: None });
        };
        let scene = maps.load(id, 0, SceneSettings::default())?;
        let file = match maps {
            MapSource::Folder(folder) => maps::file_of(folder, id)?,
            maps => maps.to_string().into(),
        };
        Ok(Self {
            image: maps::raster(&scene, maps.raster())?,
            scene: Some((scene, file)),
        })
    }

    /// Refuses the ends of a labelled link of which one lies inside a building: the maps are not those of the labels.
    pub fn check_ends(&self, tx_m: [f64; 2], rx_m: [f64; 2]) -> Result<(), ExchangeError> {
        let Some((scene, map)) = &self.scene else {
            return Ok(());
        };
        for (end, place_m) in [("transmitter", tx_m), ("receiver", rx_m)] {
            let steps = [-MARGIN_M, 0.0, MARGIN_M];
            let around = steps.into_iter().flat_map(|y| steps.map(|x| dvec2(x, y)));
            let is_inside = |by: DVec2| {
                matches!(
                    scene.locate(DVec2::from(place_m) + by),
                    Location::Inside { .. }
                )
            };
            if around.into_iter().all(is_inside) {
                let map = map.clone();
                return Err(ExchangeError::InBuilding { end, place_m, map });
            }
        }
        Ok(())
    }
}
