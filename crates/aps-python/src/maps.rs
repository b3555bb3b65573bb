//! Sources of maps.

use std::path::PathBuf;

use map2aps::maps::TileSettings;
use map2aps::{Error, MapSource};
use pyo3::prelude::*;

use crate::numbers::Number;

/// Maps as they are given.
#[derive(FromPyObject)]
pub enum Maps {
    /// A folder of RadioMapSeer files, or the GeoJSON file of a city.
    #[pyo3(transparent)]
    Path(PathBuf),
    /// Number of synthetic cities.
    #[pyo3(transparent)]
    Synthetic(Number<u32>),
}

impl Maps {
    /// The source, of which the file of a city is yet to be read.
    ///
    /// # Errors
    /// `ValueError` for what is neither a path nor a number.
    pub fn source(
        self,
        tile_m: Option<f64>,
        metric: bool,
    ) -> PyResult<impl FnOnce() -> Result<MapSource, Error>> {
        let default = TileSettings::default();
        let tiles = TileSettings {
            tile_m: tile_m.unwrap_or(default.tile_m),
            metric,
            ..default
        };
        let of_number = |number: Number<u32>| {
            let count = number.named("maps, the number of synthetic cities or else a path")?;
            Ok::<_, PyErr>(MapSource::Synthetic { count })
        };
        let known = match self {
            Self::Path(path) => Err(path),
            Self::Synthetic(number) => Ok(of_number(number)?),
        };
        Ok(move || match known {
            Ok(synthetic) => Ok(synthetic),
            Err(path) if path.is_dir() => Ok(MapSource::Folder(path)),
            Err(path) => MapSource::geojson(path, tiles),
        })
    }
}
