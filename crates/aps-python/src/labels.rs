//! Labels of links.

use map2aps::aps_label::{Array, DelayAxis, LabelConfig, Labeler, Protocol};
use map2aps::{Error, label_links};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::shaped;
use crate::given::{Given, optional};
use crate::paths::Paths;
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
    elements: Given<usize>,
    spacing_wavelengths: Given<f64>,
}

#[derive(FromPyObject)]
pub struct Circular {
    elements: Given<usize>,
    radius_wavelengths: Given<f64>,
}

impl ArrayArgument {
    fn array(self) -> PyResult<Array> {
        Ok(match self {
            Self::Linear(linear) => Array::UniformLinear {
                elements: linear.elements.named("elements")?,
                spacing_wavelengths: linear.spacing_wavelengths.named("spacing_wavelengths")?,
            },
            Self::Circular(circular) => Array::UniformCircular {
                elements: circular.elements.named("elements")?,
                radius_wavelengths: circular.radius_wavelengths.named("radius_wavelengths")?,
            },
        })
    }
}

/// Reads `paper` or `released`.
pub fn protocol(name: Given<String>) -> PyResult<Protocol> {
    let read = name.named("protocol")?.parse::<Protocol>();
    read.map_err(|error| PyValueError::new_err(format!("protocol: {error}")))
}

/// Settings of labels: those of a protocol, but for what is given.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct LabelSettings {
    protocol: Given<String>,
    array: Option<ArrayArgument>,
    sampling_rate_hz: Option<Given<f64>>,
    delay_points: Option<Given<usize>>,
    last_delay_s: Option<Given<f64>>,
}

impl LabelSettings {
    /// The settings given, and those of the protocol.
    pub fn config(self, pdp: bool) -> PyResult<LabelConfig> {
        self.or(LabelConfig::of, pdp)
    }

    /// The settings given, and others under the protocol.
    pub fn over(self, others: &LabelConfig, pdp: bool) -> PyResult<LabelConfig> {
        self.or(|protocol| others.under(protocol), pdp)
    }

    fn or(self, preset: impl FnOnce(Protocol) -> LabelConfig, pdp: bool) -> PyResult<LabelConfig> {
        let preset = preset(protocol(self.protocol)?);
        let array = self.array.map(ArrayArgument::array).transpose()?;
        let sampling_rate_hz = optional(self.sampling_rate_hz, "sampling_rate_hz")?;
        let points = optional(self.delay_points, "delay_points")?;
        let last_s = optional(self.last_delay_s, "last_delay_s")?;
        Ok(LabelConfig {
            array: array.unwrap_or(preset.array),
            sampling_rate_hz: sampling_rate_hz.unwrap_or(preset.sampling_rate_hz),
            delay_axis: DelayAxis {
                points: points.unwrap_or(preset.delay_axis.points),
                last_s: last_s.unwrap_or(preset.delay_axis.last_s),
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
    paths: &Bound<'py, Paths>,
    settings: LabelSettings,
    pdp: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let (table, config) = (&paths.get().table, settings.config(pdp)?);
    let (labeler, labels) = run(py, None, |control| {
        let labeler = Labeler::new(&config)?;
        let mut labels = label_links(&labeler, table, control)?;
        let bins = labeler.angles_deg().len();
        let spectra = labels.aps_db.chunks_exact_mut(bins);
        let profiles = labels.pdp_db.chunks_exact_mut(labeler.delays_s().len());
        for rows in [spectra, profiles] {
            let missing = rows.zip(&labels.is_labelled).filter(|(_, is)| !**is);
            missing.for_each(|(row, _)| row.fill(f64::NAN));
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
