//! Weights that come with the package.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Models whose weights are shipped, their files, and the settings of their trainings. `aps-model`, which has them, would bring
/// candle with it.
const SHIPPED: [(&str, &[u8], &str); 2] = [
    (
        "ms_areg",
        include_bytes!("../../aps-model/shipped/ms_areg/weights.safetensors"),
        include_str!("../../aps-model/shipped/ms_areg/config.json"),
    ),
    (
        "polar_reg",
        include_bytes!("../../aps-model/shipped/polar_reg/weights.safetensors"),
        include_str!("../../aps-model/shipped/polar_reg/config.json"),
    ),
];

/// The shipped weights of a model, as safetensors, and the settings of their training, as JSON.
#[pyfunction]
pub fn shipped<'py>(py: Python<'py>, name: &str) -> PyResult<(Bound<'py, PyBytes>, &'static str)> {
    let found = SHIPPED.iter().find(|(model, ..)| *model == name);
    let (_, bytes, settings) = found.ok_or_else(|| {
        let known: Vec<&str> = SHIPPED.iter().map(|(model, ..)| *model).collect();
        let known = known.join(", ");
        PyValueError::new_err(format!(
            "name: no weights of '{name}' are shipped, only of {known}"
        ))
    })?;
    Ok((PyBytes::new(py, bytes), settings))
}
