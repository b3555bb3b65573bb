//! Labelled links as networks take them.

use pyo3::prelude::*;

/// Condition images and targets of a part of a data set.
#[pyclass(module = "map2aps._native", frozen)]
pub struct Examples {}
