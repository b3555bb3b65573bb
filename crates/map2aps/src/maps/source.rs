//! Sources of maps.

use std::fmt;
use std::path::PathBuf;
#[cfg(feature = "geojson")]
use std::{path::Path, sync::Arc};

use aps_data::RasterGrid;
use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Area, CityConfig, Footprint};
use serde_json::{Value, json};

use super::{COPY_STRIDE, MapError, Orientation, SceneSettings, file_of, radiomapseer};
#[cfg(feature = "geojson")]
use super::{City, TileSettings};
use crate::error::{At, Place, Result};

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
            Self::Folder(_) | Self::Synthetic { .. } => RasterGrid::default(),
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
