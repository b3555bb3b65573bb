//! Arrays of NumPy, checked as they come in.

use std::fmt::Display;

use map2aps::aps_raytrace::glam::DVec2;
use numpy::{
    Element, PyArray1, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyException, PyMemoryError, PyValueError};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;

/// Kinds of numbers that an argument takes.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    /// Integers and floating-point numbers.
    Real,
    /// Real and complex ones.
    Complex,
    /// Integers.
    Integer,
}

impl Kind {
    /// NumPy's letters for the kind, and its name.
    fn about(self) -> (&'static str, &'static str) {
        match self {
            Self::Real => ("fiu", "real numbers"),
            Self::Complex => ("cfiu", "complex numbers"),
            Self::Integer => ("iu", "integers"),
        }
    }
}

/// An argument as an array: its name, the array, and the shape it must have.
pub struct Argument<'py> {
    name: &'static str,
    expected: String,
    array: Bound<'py, PyUntypedArray>,
}

impl<'py> Argument<'py> {
    /// Makes an array of an argument; None in `shape` is any length.
    ///
    /// # Errors
    /// `ValueError` that names type and shape, of what is expected and of what was given.
    pub fn new(
        value: &Bound<'py, PyAny>,
        name: &'static str,
        kind: Kind,
        shape: &[Option<usize>],
    ) -> PyResult<Self> {
        Self::of(array(value, name)?, name, kind, shape)
    }

    fn of(
        array: Bound<'py, PyUntypedArray>,
        name: &'static str,
        kind: Kind,
        shape: &[Option<usize>],
    ) -> PyResult<Self> {
        let (letters, kind_name) = kind.about();
        let length = |n: &Option<usize>| n.map_or("n".into(), |n| n.to_string());
        let expected = format!("{kind_name} of shape {}", tuple(shape.iter().map(length)));
        let argument = Self {
            name,
            expected,
            array,
        };
        let found = argument.array.shape();
        let fits = |(found, shape): (&usize, &Option<usize>)| shape.is_none_or(|n| n == *found);
        let has_shape = found.len() == shape.len() && found.iter().zip(shape).all(fits);
        let letter = char::from(argument.array.dtype().kind());
        // NumPy makes real numbers of a list without any.
        let has_kind = letters.contains(letter) || argument.array.is_empty() && letter == 'f';
        match has_kind && has_shape {
            true => Ok(argument),
            false => Err(argument.refuse("")),
        }
    }

    /// The exception for this argument.
    pub fn refuse(&self, why: impl Display) -> PyErr {
        let (name, expected) = (self.name, &self.expected);
        let dtype = match self.array.dtype().str() {
            Ok(dtype) => dtype,
            Err(interrupted) => return interrupted,
        };
        let shape = tuple(self.array.shape().iter().map(usize::to_string));
        PyValueError::new_err(format!(
            "{name}: expected {expected}, got dtype {dtype} of shape {shape}{why}"
        ))
    }

    /// Shape of the array.
    pub fn shape(&self) -> &[usize] {
        self.array.shape()
    }

    /// Tells if the array is of this type already.
    pub fn has_type<T: Element>(&self) -> bool {
        self.array.cast::<PyArrayDyn<T>>().is_ok()
    }

    /// Copies integers into a type.
    ///
    /// # Errors
    /// `ValueError` for one that the type does not hold.
    pub fn integers<T: TryFrom<i128>>(&self) -> PyResult<Vec<T>> {
        let convert = |value: i128| {
            let out_of_range = |_| self.refuse(format_args!(": {value} is out of range"));
            T::try_from(value).map_err(out_of_range)
        };
        if self.has_type::<u64>() {
            let values = self.values::<u64>()?.into_iter();
            return values.map(|n| convert(n.into())).collect();
        }
        let values = self.values::<i64>()?.into_iter();
        values.map(|n| convert(n.into())).collect()
    }

    /// Copies points, rows of two numbers.
    pub fn points(&self) -> PyResult<Vec<DVec2>> {
        let values = self.values::<f64>()?;
        let (points, _) = values.as_chunks();
        Ok(points.iter().copied().map(DVec2::from).collect())
    }

    /// Copies the values, row by row, into a type.
    pub fn values<T: Element + Copy>(&self) -> PyResult<Vec<T>> {
        let py = self.array.py();
        let numpy = py.import(intern!(py, "numpy"))?;
        let options = [("dtype", numpy::dtype::<T>(py))].into_py_dict(py)?;
        let function = intern!(py, "ascontiguousarray");
        let array = numpy.call_method(function, (&self.array,), Some(&options))?;
        let array: PyReadonlyArrayDyn<'py, T> = array.cast_into::<PyArrayDyn<T>>()?.readonly();
        Ok(array.as_slice()?.to_vec())
    }
}

/// Points of shape (n, 2), or one of shape (2,).
pub fn points(value: &Bound<'_, PyAny>, name: &'static str) -> PyResult<Vec<DVec2>> {
    let array = array(value, name)?;
    let shape: &[Option<usize>] = match array.shape() {
        [2] => &[Some(2)],
        _ => &[None, Some(2)],
    };
    Argument::of(array, name, Kind::Real, shape)?.points()
}

/// Makes an array of an argument.
fn array<'py>(
    value: &Bound<'py, PyAny>,
    name: &'static str,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = value.py();
    let numpy = py.import(intern!(py, "numpy"))?;
    let array = numpy.call_method1(intern!(py, "asarray"), (value,));
    let array = array.map_err(|error| match error.is_instance_of::<PyException>(py) {
        true => PyValueError::new_err(format!("{name}: no array: {error}")),
        false => error,
    });
    Ok(array?.cast_into::<PyUntypedArray>()?)
}

/// Lengths as Python writes them in a tuple.
fn tuple(lengths: impl Iterator<Item = String>) -> String {
    let lengths: Vec<String> = lengths.collect();
    let comma = if lengths.len() == 1 { "," } else { "" };
    format!("({}{comma})", lengths.join(", "))
}

/// Largest size of what is made at once \[bytes\]. Where memory is promised freely, more would be granted, and end the program
/// when it is written to.
const MAX_BYTES: usize = 16 << 30;

/// Zeros for `rows` of `values` numbers each.
///
/// # Errors
/// `MemoryError`, before anything is taken, for more than can be had.
pub fn zeros(name: &str, rows: usize, values: usize) -> PyResult<Vec<f32>> {
    let mut zeros = Vec::new();
    if !fits(rows, values) || zeros.try_reserve_exact(rows * values).is_err() {
        return Err(too_many(name, rows, values));
    }
    zeros.resize(rows * values, 0.0);
    Ok(zeros)
}

/// Tells if `rows` of `values` numbers each may be made at once.
pub fn fits(rows: usize, values: usize) -> bool {
    rows.saturating_mul(values).saturating_mul(size_of::<f32>()) <= MAX_BYTES
}

/// The exception for more than can be had at once.
pub fn too_many(name: &str, rows: usize, values: usize) -> PyErr {
    PyMemoryError::new_err(format!(
        "{name}: {rows} of {values} values each are too many at once; ask for fewer at a time, at most {} GiB",
        MAX_BYTES >> 30
    ))
}

/// An array of numbers, row by row, in a shape.
pub fn shaped<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    shape: impl Into<Vec<usize>>,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, values).reshape(shape.into())
}
