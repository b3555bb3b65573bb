//! Weights that come with the package.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Models whose weights are shipped, and their files. `aps-model`, which has them, would bring candle with it.
const SHIPPED: [(&str, &[u8]); 1] = [(
    "polar_reg",
    include_bytes!("../../aps-model/shipped/polar_reg/weights.safetensors"),
)];

/// The shipped weights of a model, as safetensors.
#[pyfunction]
pub fn shipped<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyBytes>> {
    let found = SHIPPED.iter().find(|(model, _)| *model == name);
    let (_, bytes) = found.ok_or_else(|| {
        let known: Vec<&str> = SHIPPED.iter().map(|(model, _)| *model).collect();
        let known = known.join(", ");
        PyValueError::new_err(format!(
            "name: no weights of '{name}' are shipped, only of {known}"
        ))
    })?;
    Ok(PyBytes::new(py, bytes))
}
