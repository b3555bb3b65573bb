//! Scores of predictions.

use map2aps::Error;
use map2aps::aps_metrics::{DataRange, Metric};
use map2aps::aps_metrics::{Error as MetricsError, Evaluation, Protocol, Real, Shape, Spectra};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Argument, Kind, shaped};
use crate::given::{Given, optional};
use crate::labels::protocol;
use crate::run::run_owned;

/// Spectra in the precision they came in.
enum Values {
    Single(Vec<f32>),
    Double(Vec<f64>),
}

impl Values {
    fn of(argument: &Argument<'_>) -> PyResult<Self> {
        match argument.has_type::<f32>() {
            true => argument.values().map(Self::Single),
            false => argument.values().map(Self::Double),
        }
    }
}

/// Scores predicted spectra against true ones.
#[pyfunction]
#[pyo3(signature = (truth, prediction, protocol_name, map_ids = None, data_range = None))]
pub fn metrics<'py>(
    py: Python<'py>,
    truth: &Bound<'py, PyAny>,
    prediction: &Bound<'py, PyAny>,
    protocol_name: Given<String>,
    map_ids: Option<&Bound<'py, PyAny>>,
    data_range: Option<Given<f64>>,
) -> PyResult<Bound<'py, PyDict>> {
    let truth = Argument::new(truth, "truth", Kind::Real, &[None, None])?;
    let prediction = Argument::new(prediction, "prediction", Kind::Real, &[None, None])?;
    let [shape, predicted] = [&truth, &prediction].map(|spectra| Shape {
        samples: spectra.shape()[0],
        bins: spectra.shape()[1],
    });
    if shape != predicted {
        let (truth, prediction) = (shape, predicted);
        let error = MetricsError::ShapeMismatch { truth, prediction };
        return Err(crate::error::exception(error));
    }
    let map_ids = map_ids.map(|ids| {
        let ids = Argument::new(ids, "map_ids", Kind::Integer, &[Some(shape.samples)])?;
        ids.integers::<u32>()
    });
    let map_ids = map_ids.transpose()?;
    let definition = Protocol::from(protocol(protocol_name)?);
    let (truth, prediction) = (Values::of(&truth)?, Values::of(&prediction)?);
    let bins = shape.bins;
    let evaluation = run_owned(py, move || {
        let ids = map_ids.as_deref();
        let evaluation = Evaluation::new(definition);
        match (&truth, &prediction) {
            (Values::Single(t), Values::Single(p)) => score(evaluation, t, p, bins, ids),
            (Values::Single(t), Values::Double(p)) => score(evaluation, t, p, bins, ids),
            (Values::Double(t), Values::Single(p)) => score(evaluation, t, p, bins, ids),
            (Values::Double(t), Values::Double(p)) => score(evaluation, t, p, bins, ids),
        }
    })?;
    let range = match optional(data_range, "data_range")? {
        Some(range) => DataRange::new(range).map_err(crate::error::exception)?,
        None => {
            let range = evaluation.truth_range();
            range.ok_or_else(|| nothing_scored(&evaluation))?
        }
    };
    if evaluation.scored().is_empty() {
        return Err(nothing_scored(&evaluation));
    }
    let (evaluation, report, columns) = run_owned(py, move || {
        let columns = Metric::ALL.map(|metric| (metric, evaluation.column(metric, range)));
        let report = serde_json::to_string(&evaluation.report(range))?;
        Ok((evaluation, report, columns))
    })?;
    let rows = evaluation.scored().iter();
    let rows: Vec<i64> = rows.map(|sample| sample.sample as i64).collect();
    let rejected = evaluation.rejected().iter();
    let rejected: Vec<i64> = rejected.map(|sample| sample.sample as i64).collect();
    let values = PyDict::new(py);
    for (metric, column) in columns {
        let length = column.len();
        values.set_item(metric.key(), shaped(py, column, [length])?)?;
    }
    let found = PyDict::new(py);
    found.set_item("values", values)?;
    found.set_item("truth_maximum", evaluation.truth_maximum())?;
    for (name, rows) in [("rows", rows), ("rejected", rejected)] {
        let count = rows.len();
        found.set_item(name, shaped(py, rows, [count])?)?;
    }
    found.set_item("report", report)?;
    Ok(found)
}

fn score<T: Real, P: Real>(
    mut evaluation: Evaluation,
    truth: &[T],
    prediction: &[P],
    bins: usize,
    map_ids: Option<&[u32]>,
) -> Result<Evaluation, Error> {
    let (truth, prediction) = (Spectra::new(truth, bins)?, Spectra::new(prediction, bins)?);
    evaluation.push(truth, prediction, map_ids)?;
    Ok(evaluation)
}

fn nothing_scored(evaluation: &Evaluation) -> PyErr {
    let samples = evaluation.samples();
    PyValueError::new_err(match evaluation.rejected().first() {
        Some(first) => format!(
            "none of {samples} samples can be scored; the first: {}",
            first.defect
        ),
        None => "truth and prediction hold no sample".into(),
    })
}
