//! The tracer.

use std::sync::Arc;

use map2aps::aps_raytrace::glam::DVec2;
use map2aps::aps_raytrace::{self, Material, TraceConfig};
use map2aps::{Error, Limits, UnknownLimits, trace_links, trace_pairs};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::points;
use crate::error::{exception, tried};
use crate::given::{Given, optional};
use crate::paths::Paths;
use crate::run::{run, run_owned};
use crate::scene::Scene;

/// A scene prepared for one configuration.
#[derive(Debug)]
#[pyclass(module = "map2aps._native", frozen)]
pub struct Tracer {
    tracer: aps_raytrace::Tracer<'static>,
    digest: Arc<str>,
}

#[pymethods]
impl Tracer {
    #[new]
    #[pyo3(signature = (scene, **limits))]
    fn new(
        py: Python<'_>,
        scene: &Bound<'_, Scene>,
        limits: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let digest = Arc::from(scene.get().digest());
        let (scene, config) = (scene.get().scene.clone(), config(limits)?);
        let make = move || Ok(aps_raytrace::Tracer::owning(scene, config)?);
        Ok(Self {
            tracer: run_owned(py, make)?,
            digest,
        })
    }

    fn trace(
        &self,
        py: Python<'_>,
        tx: &Bound<'_, PyAny>,
        rx: &Bound<'_, PyAny>,
    ) -> PyResult<Paths> {
        let (tx, rx) = (points(tx, "tx")?, points(rx, "rx")?);
        let table = run(py, None, |control| {
            trace_links(&self.tracer, &tx, &rx, control)
        })?;
        let pairs = tx.iter().flat_map(|&tx| rx.iter().map(move |&rx| [tx, rx]));
        Ok(Paths::traced(table, pairs, &self.digest))
    }

    fn trace_pairs(
        &self,
        py: Python<'_>,
        tx: &Bound<'_, PyAny>,
        rx: &Bound<'_, PyAny>,
    ) -> PyResult<Paths> {
        let (tx, rx) = (points(tx, "tx")?, points(rx, "rx")?);
        if tx.len() != rx.len() {
            let (tx, rx) = (tx.len(), rx.len());
            let text = format!("rx: {rx} points for {tx} transmitters: there must be one each");
            return Err(PyValueError::new_err(text));
        }
        let pairs: Vec<[DVec2; 2]> = tx.into_iter().zip(rx).map(Into::into).collect();
        let table = run(py, None, |control| {
            trace_pairs(&self.tracer, &pairs, |paths| paths, control)
        })?;
        Ok(Paths::traced(table, pairs.into_iter(), &self.digest))
    }
}

/// Reads the settings of a trace.
///
/// # Errors
/// `TypeError` for an unknown name, `ValueError` for a value of another type or out of its range.
pub fn config(limits: Option<&Bound<'_, PyDict>>) -> PyResult<TraceConfig> {
    let named = limits.map(|limits| limits.get_item("limits")).transpose()?;
    let mut config = match named.flatten() {
        Some(name) => of_limits(&name)?,
        None => Limits::default().config(),
    };
    for (name, value) in limits.into_iter().flatten() {
        set(&mut config, &name.extract::<String>()?, &value)?;
    }
    let is_given = |limits: &Bound<'_, PyDict>| limits.contains("max_interactions");
    if !limits.map_or(Ok(false), is_given)? {
        let (reflections, diffractions) = (config.max_reflections, config.max_diffractions);
        config.max_interactions = reflections.saturating_add(diffractions);
    }
    config.validate().map_err(|e| exception(Error::from(e)))?;
    Ok(config)
}

fn set(config: &mut TraceConfig, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
    let number = || value.extract::<Given<usize>>()?.named(name);
    match name {
        // Known before the others, which change single ones of them.
        "limits" => (),
        "frequency_hz" => config.frequency_hz = value.extract::<Given<_>>()?.named(name)?,
        "material" => config.material = material(value)?,
        "max_reflections" => config.max_reflections = number()?,
        "max_diffractions" => config.max_diffractions = number()?,
        "max_interactions" => config.max_interactions = number()?,
        "slope_diffraction" => {
            config.slope_diffraction = value.extract::<Given<_>>()?.named(name)?
        }
        "dynamic_range_db" => config.dynamic_range_db = optional(value.extract()?, name)?,
        "max_fallback_diffractions" => config.max_fallback_diffractions = number()?,
        "max_images" => config.max_images = number()?,
        "max_wave_bytes" => config.max_wave_bytes = number()?,
        _ => {
            let text = format!("{name}: no such setting of a trace");
            return Err(PyTypeError::new_err(text));
        }
    }
    Ok(())
}

/// The settings of limits by their name.
fn of_limits(name: &Bound<'_, PyAny>) -> PyResult<TraceConfig> {
    let text = tried(name.py(), name.extract::<String>())?;
    let limits = match text {
        Some(text) => text.parse::<Limits>(),
        None => Err(UnknownLimits(name.repr()?.to_string())),
    };
    let limits = limits.map_err(|e| PyValueError::new_err(format!("limits: {e}")))?;
    Ok(limits.config())
}

/// `concrete`, `pec`, or relative permittivity and conductivity \[S/m\].
fn material(value: &Bound<'_, PyAny>) -> PyResult<Material> {
    let py = value.py();
    if let Some((relative_permittivity, conductivity_s_per_m)) = tried(py, value.extract())? {
        return Ok(Material::Dielectric {
            relative_permittivity,
            conductivity_s_per_m,
        });
    }
    match tried(py, value.extract::<&str>())?.map(str::parse) {
        Some(Ok(material)) => Ok(material),
        _ => Err(PyValueError::new_err(format!(
            "material: {} is neither 'concrete' nor 'pec' nor a pair (relative permittivity, conductivity in S/m)",
            value.repr()?
        ))),
    }
}
