//! Labelled links as networks take them.

use std::path::PathBuf;
use std::sync::Arc;

use map2aps::maps::TileSettings;
use map2aps::{Dataset, Domain, DrawnExamples, Part};
use numpy::PyArrayDyn;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::{Argument, Kind, shaped, zeros};
use crate::given::Given;
use crate::maps::Maps;
use crate::polar::all_ways;
use crate::run::run_owned;

/// Largest side of an image \[pixels\].
const MAX_SIZE: usize = 4096;

/// Form of the examples.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Settings {
    size: Given<usize>,
    mirror: Given<bool>,
    linear: bool,
    polar: bool,
    maps: Option<Maps>,
}

/// Inputs of a model and targets, of a part of a data set.
#[derive(Debug)]
#[pyclass(module = "map2aps._native", frozen)]
pub struct Examples {
    drawn: Arc<DrawnExamples>,
}

/// Inputs of shape (numbers, 3, size, size) or (numbers, ways, values), and targets of shape (numbers, bins).
type Batch<'py> = (Bound<'py, PyArrayDyn<f32>>, Bound<'py, PyArrayDyn<f32>>);

#[pymethods]
impl Examples {
    #[new]
    fn new(
        py: Python<'_>,
        folder: PathBuf,
        split: Given<String>,
        settings: Settings,
    ) -> PyResult<Self> {
        let part = split.named("split")?.parse::<Part>();
        let part = part.map_err(|error| PyValueError::new_err(format!("split: {error}")))?;
        let size = settings.size.named("size")?;
        if !(1..=MAX_SIZE).contains(&size) {
            let text = format!("size: {size} pixels; must be 1 to {MAX_SIZE}");
            return Err(PyValueError::new_err(text));
        }
        let is_mirrored = settings.mirror.named("mirror")? && part == Part::Train;
        let domain = match settings.linear {
            true => Domain::Linear,
            false => Domain::Normalised,
        };
        let source = settings.maps.map(Maps::source).transpose()?;
        let drawn = run_owned(py, move || {
            let dataset = Dataset::open(&folder)?;
            let drawn = DrawnExamples::open(&dataset, part, domain, size, is_mirrored)?;
            if !settings.polar {
                return Ok(drawn);
            }
            let tiles = TileSettings::of_dataset(&dataset.manifest().configuration);
            let maps = source.map(|source| source(tiles)).transpose()?;
            drawn.with_ways(maps.as_ref())
        })?;
        let drawn = Arc::new(drawn);
        Ok(Self { drawn })
    }

    fn __len__(&self) -> usize {
        self.drawn.len()
    }

    fn batch<'py>(&self, py: Python<'py>, indices: &Bound<'py, PyAny>) -> PyResult<Batch<'py>> {
        let numbers =
            Argument::new(indices, "indices", Kind::Integer, &[None])?.integers::<i128>()?;
        let count = self.drawn.len();
        let inside = |number: i128| {
            let inside = usize::try_from(number).ok().filter(|&n| n < count);
            inside.ok_or_else(|| {
                let text = format!("indices: {number} is not from 0 to below {count}");
                PyIndexError::new_err(text)
            })
        };
        let numbers = numbers
            .into_iter()
            .map(inside)
            .collect::<PyResult<Vec<_>>>()?;
        let (drawn, rows) = (Arc::clone(&self.drawn), numbers.len());
        let bins = drawn.examples().bins();
        let mut targets = zeros("indices", rows, bins)?;
        if let Some(shape) = drawn.image_shape() {
            let mut images = zeros("indices", rows, shape.iter().product())?;
            let (images, targets) = run_owned(py, move || {
                drawn.write_images(&numbers, &mut images);
                drawn.write_targets(&numbers, &mut targets)?;
                Ok((images, targets))
            })?;
            let images = shaped(py, images, [&[rows], &shape[..]].concat())?;
            return Ok((images, shaped(py, targets, [rows, bins])?));
        }
        let ways = all_ways(py, "indices", rows, |some| {
            self.drawn.ways(&numbers[some]).expect("no images")
        })?;
        let targets = run_owned(py, move || {
            drawn.write_targets(&numbers, &mut targets)?;
            Ok(targets)
        })?;
        Ok((ways, shaped(py, targets, [rows, bins])?))
    }

    /// Map, row of the link in it, and rows of transmitter and receiver of each example; shape (examples, 4).
    #[getter]
    fn links<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        let list = self.drawn.examples().list();
        let row = |e: &map2aps::Example| [e.map.into(), e.link as i64, e.tx.into(), e.rx.into()];
        shaped(py, list.iter().flat_map(row).collect(), [list.len(), 4])
    }
}
