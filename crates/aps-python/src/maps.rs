//! Sources of maps.

use std::path::PathBuf;

use map2aps::maps::TileSettings;
use map2aps::{Error, MapSource};
use pyo3::prelude::*;

use crate::given::Given;

/// Maps as they are given.
#[derive(FromPyObject)]
pub enum Maps {
    /// A folder of RadioMapSeer files, or the GeoJSON file of a city.
    #[pyo3(transparent)]
    Path(PathBuf),
    /// Number of synthetic cities.
    #[pyo3(transparent)]
    Synthetic(Given<u32>),
}

impl Maps {
    /// The source, made of the settings by which the file of a city is cut. Making it reads that file.
    ///
    /// # Errors
    /// `ValueError` for what is neither a path nor a number.
    pub fn source(self) -> PyResult<impl FnOnce(TileSettings) -> Result<MapSource, Error>> {
        let of_number = |number: Given<u32>| {
            let count = number.named("maps, a path or the number of synthetic cities")?;
            Ok::<_, PyErr>(MapSource::Synthetic { count })
        };
        let known = match self {
            Self::Path(path) => Err(path),
            Self::Synthetic(number) => Ok(of_number(number)?),
        };
        Ok(move |tiles| match known {
            Ok(synthetic) => Ok(synthetic),
            Err(path) if path.is_dir() => Ok(MapSource::Folder(path)),
            Err(path) => MapSource::geojson(path, tiles),
        })
    }
}
