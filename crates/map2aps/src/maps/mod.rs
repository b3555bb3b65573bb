//! Maps: a folder of RadioMapSeer files, tiles of a city in GeoJSON, or synthetic cities.

#[cfg(feature = "geojson")]
mod city;
mod error;
pub(crate) mod identity;
mod ids;
#[cfg(feature = "geojson")]
mod named;
mod orientation;
mod radiomapseer;

use std::fmt;
use std::path::PathBuf;
#[cfg(feature = "geojson")]
use std::{path::Path, sync::Arc};

use aps_data::{Raster, RasterGrid};
use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Area, CityConfig, Footprint, SceneConfig};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::error::{At, Place, Result};

#[cfg(feature = "geojson")]
pub use city::{City, TileSettings, load_bytes, load_file};
pub use error::MapError;
pub use ids::{choose, parse_ids, ranges};
#[cfg(feature = "geojson")]
pub use named::NamedMaps;
pub(crate) use orientation::split_of_imported;
pub use orientation::{COPY_STRIDE, MAX_ORIENTATIONS, Orientation, split, with_copies};
pub use radiomapseer::file_of;

/// A map needs a building as large as this [m].
const MIN_BUILDING_M: f64 = 1.0;

/// Source of maps.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum MapSource {
    /// Folder of RadioMapSeer files `0.json`, `1.json`, ..., also with zeros before the number.
    Folder(PathBuf),
    /// Tiles of a city in GeoJSON.
    #[cfg(feature = "geojson")]
    City(Arc<City>),
    /// Synthetic cities.
    Synthetic {
        /// Number of maps.
        count: u32,
    },
}

/// Settings of the scenes made from maps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSettings {
    /// Slits between walls that are narrower are filled \[m\]; 0 leaves all open.
    pub close_gaps_m: f64,
    /// Orientations that each training map is taken in: the first so many of its quarter turns and their mirror images. Copy
    /// `k` of map `id` has the id `k * `[`COPY_STRIDE`]` + id`. 1, which manifests do not state, is the map alone.
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

impl MapSource {
    /// Reads a city in GeoJSON and cuts it into maps.
    ///
    /// # Errors
    /// A file that cannot be read, is no GeoJSON, or holds no map.
    #[cfg(feature = "geojson")]
    pub fn geojson(file: impl AsRef<Path>, settings: TileSettings) -> Result<Self> {
        Ok(Self::City(Arc::new(City::read(file.as_ref(), settings)?)))
    }

    /// The maps of a data set, if they can be made without a file: synthetic cities.
    pub fn of_dataset(configuration: &Value) -> Option<Self> {
        (configuration["maps"] == "synthetic").then_some(Self::Synthetic { count: 0 })
    }

    /// Refuses maps that are not those of a data set, as far as its manifest's `configuration` tells.
    ///
    /// # Errors
    /// [`MapError::OtherMaps`].
    pub fn must_be_of(&self, configuration: &Value) -> Result<(), MapError> {
        let (stored, given) = (&configuration["maps"], self.describe());
        let is_same = match (stored, &given) {
            (Value::Null, _) => true,
            // Manifests of earlier versions say less.
            (Value::Object(stored), Value::Object(given)) => stored
                .iter()
                .all(|(name, value)| given.get(name) == Some(value)),
            _ => *stored == given,
        };
        match is_same {
            true => Ok(()),
            false => Err(MapError::OtherMaps {
                stored: stored.clone(),
                given,
            }),
        }
    }

    /// Describes the settings that decide the maps, as a manifest keeps them.
    pub fn describe(&self) -> Value {
        match self {
            Self::Folder(_) => json!("radiomapseer"),
            #[cfg(feature = "geojson")]
            Self::City(city) => city.describe(),
            Self::Synthetic { .. } => json!("synthetic"),
        }
    }

    /// The grid of a map's image: 256 x 256 pixels, whatever its size.
    pub fn raster(&self) -> RasterGrid {
        match self {
            #[cfg(feature = "geojson")]
            Self::City(city) => RasterGrid::square(256, city.side_m()),
            _ => RasterGrid::default(),
        }
    }

    /// The ids of the maps, ascending.
    ///
    /// # Errors
    /// A folder that cannot be read, holds no map, or two files of one; more synthetic cities than there are ids for.
    pub fn ids(&self) -> Result<Vec<u32>> {
        match self {
            Self::Folder(folder) => radiomapseer::ids(folder),
            #[cfg(feature = "geojson")]
            Self::City(city) => Ok(city.ids().to_vec()),
            &Self::Synthetic { count } if count > COPY_STRIDE => {
                Err(MapError::TooMany(count).into())
            }
            &Self::Synthetic { count } => Ok((0..count).collect()),
        }
    }

    /// Reads and checks one map, or the copy of it that the id stands for. Synthetic city `id` has the seed `seed + id`, whatever
    /// the number of maps.
    ///
    /// # Errors
    /// A map that is not there, cannot be read, or makes no scene; the id of a copy that the settings do not have.
    pub fn load(&self, id: u32, seed: u64, settings: SceneSettings) -> Result<Scene> {
        let (map, orientation) = Orientation::of_id(id, settings.orientations)?;
        let (footprints, area) = self.footprints(map, seed)?;
        let scene = settings.scene(&orientation.turn(footprints, area), area);
        match self {
            Self::Folder(folder) => scene.at_file(Place::MapFile, &file_of(folder, map)?),
            #[cfg(feature = "geojson")]
            Self::City(_) => scene.at(Place::Tile(map)),
            Self::Synthetic { .. } => scene,
        }
    }

    /// Reads the footprints of one map as they are, before any repair, and its area.
    ///
    /// # Errors
    /// A map that is not there or cannot be read.
    pub fn footprints(&self, id: u32, seed: u64) -> Result<(Vec<Footprint>, Area)> {
        match self {
            Self::Folder(folder) => {
                let file = file_of(folder, id)?;
                let bytes = std::fs::read(&file).at_file(Place::MapFile, &file)?;
                let footprints = radiomapseer::footprints(&bytes).at_file(Place::MapFile, &file)?;
                Ok((footprints, Area::RADIOMAPSEER))
            }
            #[cfg(feature = "geojson")]
            Self::City(city) => {
                let tile = city.tile(id)?;
                Ok((tile.footprints, tile.area))
            }
            Self::Synthetic { .. } => synthetic(id, seed),
        }
    }
}

/// Footprints and area of synthetic city `id`.
fn synthetic(id: u32, seed: u64) -> Result<(Vec<Footprint>, Area)> {
    let config = CityConfig {
        seed: seed.wrapping_add(u64::from(id)),
        ..CityConfig::default()
    };
    let area = Area {
        min: DVec2::ZERO,
        max: DVec2::splat(config.size_m.into()),
    };
    Ok((config.footprints()?, area))
}

impl fmt::Display for MapSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Folder(path) => write!(f, "{}", path.display()),
            #[cfg(feature = "geojson")]
            Self::City(city) => write!(f, "{}", city.file().display()),
            Self::Synthetic { .. } => write!(f, "synthetic city"),
        }
    }
}

/// Draws the image of a scene's buildings.
///
/// # Errors
/// A grid that makes no image.
pub fn raster(scene: &Scene, grid: RasterGrid) -> Result<Raster> {
    Ok(Raster::of_outlines(&outlines(scene), grid)?)
}

/// Rings of a scene's buildings \[m\].
pub(crate) fn outlines(scene: &Scene) -> Vec<Vec<[f64; 2]>> {
    let ring = |ring: &Vec<DVec2>| ring.iter().map(DVec2::to_array).collect();
    scene.outlines().iter().map(ring).collect()
}

/// Bounding box of some points.
fn bounds(points: &[DVec2]) -> (DVec2, DVec2) {
    let grow = |(min, max): (DVec2, DVec2), &p: &DVec2| (min.min(p), max.max(p));
    let none = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    points.iter().fold(none, grow)
}
