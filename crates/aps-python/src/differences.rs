//! Differences between the labels that a model learnt and those of a data set.

use map2aps::Difference;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde_json::Value;

use crate::given::Given;
use crate::labels;

/// The differences, in words, with a mark of those that change the meaning of a spectrum. Both configurations are JSON.
#[pyfunction]
pub fn label_differences(
    protocol: Given<String>,
    learnt: &str,
    found: &str,
) -> PyResult<Vec<(bool, String)>> {
    let value = |text| {
        let parsed: Result<Value, _> = serde_json::from_str(text);
        parsed.map_err(|error| PyValueError::new_err(format!("configuration: {error}")))
    };
    let all = Difference::all(labels::protocol(protocol)?, &value(learnt)?, &value(found)?);
    let told = all.iter().map(|d| (d.is_of_meaning(), d.to_string()));
    Ok(told.collect())
}
