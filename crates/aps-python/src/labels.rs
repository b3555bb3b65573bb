//! Labels of links.

use map2aps::aps_data::FILL_DB;
use map2aps::aps_label::{Array, DelayAxis, LabelConfig, Labeler, Protocol};
use map2aps::{Error, label_links};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::shaped;
use crate::paths;
use crate::run::run;

/// `map2aps.UniformLinear` or `map2aps.UniformCircular`.
#[derive(FromPyObject)]
pub enum ArrayArgument {
    #[pyo3(transparent)]
    Linear(Linear),
    #[pyo3(transparent)]
    Circular(Circular),
}

#[derive(FromPyObject)]
pub struct Linear {
    elements: usize,
    spacing_wavelengths: f64,
}

#[derive(FromPyObject)]
pub struct Circular {
    elements: usize,
    radius_wavelengths: f64,
}

impl From<ArrayArgument> for Array {
    fn from(array: ArrayArgument) -> Self {
        match array {
            ArrayArgument::Linear(linear) => Self::UniformLinear {
                elements: linear.elements,
                spacing_wavelengths: linear.spacing_wavelengths,
            },
            ArrayArgument::Circular(circular) => Self::UniformCircular {
                elements: circular.elements,
                radius_wavelengths: circular.radius_wavelengths,
            },
        }
    }
}

/// Reads `paper` or `released`.
pub fn protocol(name: &str) -> PyResult<Protocol> {
    let read = name.parse::<Protocol>();
    read.map_err(|error| PyValueError::new_err(format!("protocol: {error}")))
}

/// Settings of labels: those of a protocol, but for what is given.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct LabelSettings {
    protocol: String,
    array: Option<ArrayArgument>,
    sampling_rate_hz: Option<f64>,
    delay_points: Option<usize>,
    last_delay_s: Option<f64>,
}

impl LabelSettings {
    pub fn config(self, pdp: bool) -> PyResult<LabelConfig> {
        let preset = LabelConfig::of(protocol(&self.protocol)?);
        Ok(LabelConfig {
            array: self.array.map_or(preset.array, Array::from),
            sampling_rate_hz: self.sampling_rate_hz.unwrap_or(preset.sampling_rate_hz),
            delay_axis: DelayAxis {
                points: self.delay_points.unwrap_or(preset.delay_axis.points),
                last_s: self.last_delay_s.unwrap_or(preset.delay_axis.last_s),
            },
            pdp,
            ..preset
        })
    }
}

/// Labels the links of a `map2aps.Paths`.
#[pyfunction]
pub fn label<'py>(
    py: Python<'py>,
    paths: &Bound<'py, PyAny>,
    settings: LabelSettings,
    pdp: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let table = paths::table(paths)?;
    let config = settings.config(pdp)?;
    let (labeler, labels) = run(py, None, |control| {
        let labeler = Labeler::new(&config)?;
        let mut labels = label_links(&labeler, &table, control)?;
        for values in [&mut labels.aps_db, &mut labels.pdp_db] {
            let missing = values.iter_mut().filter(|value| **value == FILL_DB);
            missing.for_each(|value| *value = f64::NAN);
        }
        Ok::<_, Error>((labeler, labels))
    })?;
    let links = labels.is_labelled.len();
    let (angles_deg, delays_s) = (labeler.angles_deg().to_vec(), labeler.delays_s().to_vec());
    let (bins, delays) = (angles_deg.len(), delays_s.len());
    let found = PyDict::new(py);
    found.set_item("is_labelled", shaped(py, labels.is_labelled, [links])?)?;
    found.set_item("aps_db", shaped(py, labels.aps_db, [links, bins])?)?;
    found.set_item("angle_deg", shaped(py, angles_deg, [bins])?)?;
    if pdp {
        found.set_item("pdp_db", shaped(py, labels.pdp_db, [links, delays])?)?;
        found.set_item("delay_s", shaped(py, delays_s, [delays])?)?;
    }
    Ok(found)
}
