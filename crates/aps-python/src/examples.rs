//! Labelled links as networks take them.

use std::path::PathBuf;

use map2aps::{Dataset, Domain, DrawnExamples, Part};
use numpy::PyArrayDyn;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::{Argument, Kind, shaped};
use crate::numbers::Number;
use crate::run::run;

/// Largest side of an image \[pixels\].
const MAX_SIZE: usize = 4096;

/// Condition images and targets of a part of a data set.
#[pyclass(module = "map2aps._native", frozen)]
pub struct Examples {
    drawn: DrawnExamples,
}

/// Images of shape (numbers, 3, size, size), and targets of shape (numbers, bins).
type Batch<'py> = (Bound<'py, PyArrayDyn<f32>>, Bound<'py, PyArrayDyn<f32>>);

#[pymethods]
impl Examples {
    #[new]
    fn new(
        py: Python<'_>,
        folder: PathBuf,
        split: &str,
        size: Number<usize>,
        mirror: bool,
        linear: bool,
    ) -> PyResult<Self> {
        let part = match split {
            "train" => Part::Train,
            "develop" => Part::Develop,
            "test" => Part::Test,
            _ => {
                let text = format!("split: '{split}' is none of 'train', 'develop' and 'test'");
                return Err(PyValueError::new_err(text));
            }
        };
        let size = size.named("size")?;
        if !(1..=MAX_SIZE).contains(&size) {
            let text = format!("size: {size} pixels; must be 1 to {MAX_SIZE}");
            return Err(PyValueError::new_err(text));
        }
        let domain = match linear {
            true => Domain::Linear,
            false => Domain::Normalised,
        };
        let drawn = run(py, None, |_| {
            DrawnExamples::load(&Dataset::open(&folder)?, part, domain, size, mirror)
        })?;
        Ok(Self { drawn })
    }

    fn __len__(&self) -> usize {
        self.drawn.len()
    }

    fn batch<'py>(&self, py: Python<'py>, numbers: &Bound<'py, PyAny>) -> PyResult<Batch<'py>> {
        let numbers = Argument::new(numbers, "numbers", Kind::Integer, &[None])?.values::<i64>()?;
        let count = self.drawn.len();
        let inside = |&number: &i64| usize::try_from(number).ok().filter(|&n| n < count);
        let inside: Option<Vec<usize>> = numbers.iter().map(inside).collect();
        let Some(numbers) = inside else {
            let text = format!("numbers: {numbers:?} must be from 0 to below {count}");
            return Err(PyIndexError::new_err(text));
        };
        let examples = self.drawn.examples();
        let (bins, [rows, columns]) = (examples.bins(), examples.image_shape());
        let (images, targets) = run(py, None, |_| {
            let mut images = vec![0.0; numbers.len() * examples.image_len()];
            let mut targets = vec![0.0; numbers.len() * bins];
            self.drawn.write(&numbers, &mut images, &mut targets)?;
            Ok((images, targets))
        })?;
        let images = shaped(py, images, [numbers.len(), 3, rows, columns])?;
        Ok((images, shaped(py, targets, [numbers.len(), bins])?))
    }

    /// Map, row of the link in it, and rows of transmitter and receiver of each example; shape (examples, 4).
    #[getter]
    fn links<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        let list = self.drawn.examples().list();
        let row = |e: &map2aps::Example| [e.map.into(), e.link as i64, e.tx.into(), e.rx.into()];
        shaped(py, list.iter().flat_map(row).collect(), [list.len(), 4])
    }
}
