//! Sources of maps.

use std::ffi::CString;
use std::path::PathBuf;

use map2aps::maps::{City, TileSettings};
use map2aps::{Error, MapSource};
use pyo3::exceptions::{PyUserWarning, PyValueError};
use pyo3::prelude::*;

use crate::given::Given;

/// Maps as they are given: a folder of RadioMapSeer files or the GeoJSON file of a city, or the number of synthetic cities.
pub struct Maps {
    path: Given<PathBuf>,
    count: Given<u32>,
}

impl<'a, 'py> FromPyObject<'a, 'py> for Maps {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self {
            path: given.extract()?,
            count: given.extract()?,
        })
    }
}

impl Maps {
    /// The source, made of the settings by which the file of a city is cut. Making it reads that file.
    ///
    /// # Errors
    /// `ValueError` for what is neither a path nor a number.
    pub fn source(self) -> PyResult<impl FnOnce(TileSettings) -> Result<MapSource, Error>> {
        let known = match self.path.ok()? {
            Some(path) => Err(path),
            None => {
                let name = "maps, a path or the number of synthetic cities";
                let count = self.count.named(name)?;
                if count == 0 {
                    return Err(PyValueError::new_err("maps: 0 is no number of maps"));
                }
                Ok(MapSource::Synthetic { count })
            }
        };
        Ok(move |tiles| match known {
            Ok(synthetic) => Ok(synthetic),
            Err(path) if path.is_dir() => Ok(MapSource::Folder(path)),
            Err(path) => MapSource::geojson(path, tiles),
        })
    }
}

/// Warns of features, buildings and rings of a city's file that became no building. The line of Python that the warning is shown with is `level` calls up.
///
/// # Errors
/// The warning, where Python makes exceptions of warnings.
pub fn tell_passed_over(py: Python<'_>, city: &City, level: i32) -> PyResult<()> {
    let passed_over = city.passed_over();
    if passed_over.is_empty() {
        return Ok(());
    }
    let remedy = match city.skipped().features {
        0 => "",
        _ => "; all_polygons=True takes every polygon for a building",
    };
    let text = format!("{}: {passed_over}{remedy}", city.file().display());
    let text = CString::new(text).expect("no path holds a zero");
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, level)
}
