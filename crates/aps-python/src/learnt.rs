//! Facts of a data set's labels that a model learns besides the spectra.

use std::path::PathBuf;

use map2aps::aps_data::{ConditionConfig, Dataset};
use map2aps::{PolarViews, settings, targets};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use serde_json::json;

use crate::arrays::shaped;
use crate::run::run_owned;

/// Facts of a data set that predictions need, as JSON: those of a run's `config.json` that are not of the model.
#[pyfunction]
pub fn training_facts(py: Python<'_>, folder: PathBuf) -> PyResult<String> {
    run_owned(py, move || {
        let dataset = Dataset::open(&folder)?;
        let (protocol, statistics, _) = targets::learning_target(&dataset)?;
        let facts = json!({
            "sigma_px": ConditionConfig::default().sigma_px,
            "frame": "map",
            // JSON is of UTF-8, which a path need not be.
            "data": folder.to_string_lossy(),
            "data_configuration": dataset.manifest().configuration,
            "protocol": protocol.to_string(),
            "training_statistics": statistics,
        });
        Ok(facts.to_string())
    })
}

/// Response of the array that a data set's labels are of, shape (bins, rays).
#[pyfunction]
pub fn array_response(py: Python<'_>, folder: PathBuf) -> PyResult<Bound<'_, PyArrayDyn<f64>>> {
    let (response, bins) = run_owned(py, move || {
        let dataset = Dataset::open(&folder)?;
        let manifest = dataset.manifest();
        let axis = dataset.aps_layout()?.axis;
        let label = settings::label_of(&manifest.configuration)?;
        let response = PolarViews::array_response(&label.array, axis.values());
        Ok((response, axis.count))
    })?;
    shaped(py, response, [bins, PolarViews::fan().directions])
}
