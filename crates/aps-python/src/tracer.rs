//! The tracer.

use map2aps::aps_raytrace::{self, Material, TraceConfig};
use map2aps::{Control, Error, trace_links};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::points;
use crate::error::exception;
use crate::paths;
use crate::run::run;
use crate::scene::Scene;

/// A scene prepared for one configuration.
#[pyclass(module = "map2aps._native", frozen)]
pub struct Tracer {
    tracer: aps_raytrace::Tracer<'static>,
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
        let (scene, config) = (scene.get().scene.clone(), config(limits)?);
        let make = |_: &Control<'_>| Ok(aps_raytrace::Tracer::owning(scene, config)?);
        Ok(Self {
            tracer: run(py, None, make)?,
        })
    }

    fn trace<'py>(
        &self,
        py: Python<'py>,
        tx: &Bound<'py, PyAny>,
        rx: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (tx, rx) = (points(tx, "tx")?, points(rx, "rx")?);
        let table = run(py, None, |control| {
            trace_links(&self.tracer, &tx, &rx, control)
        })?;
        paths::arrays(py, table)
    }
}

/// Reads the settings of a trace.
///
/// # Errors
/// `TypeError` for an unknown name or a value of another type, `ValueError` for a material of an unknown name.
pub fn config(limits: Option<&Bound<'_, PyDict>>) -> PyResult<TraceConfig> {
    let mut config = TraceConfig::default();
    for (name, value) in limits.into_iter().flatten() {
        let name: String = name.extract()?;
        let read = set(&mut config, &name, &value);
        read.map_err(
            |error| match error.is_instance_of::<PyTypeError>(value.py()) {
                true => PyTypeError::new_err(format!("{name}: {}", error.value(value.py()))),
                false => error,
            },
        )?;
    }
    config.validate().map_err(|e| exception(Error::from(e)))?;
    Ok(config)
}

fn set(config: &mut TraceConfig, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
    match name {
        "frequency_hz" => config.frequency_hz = value.extract()?,
        "material" => config.material = material(value)?,
        "max_reflections" => config.max_reflections = value.extract()?,
        "max_diffractions" => config.max_diffractions = value.extract()?,
        "max_interactions" => config.max_interactions = value.extract()?,
        "slope_diffraction" => config.slope_diffraction = value.extract()?,
        "dynamic_range_db" => config.dynamic_range_db = value.extract()?,
        "max_fallback_diffractions" => config.max_fallback_diffractions = value.extract()?,
        "max_images" => config.max_images = value.extract()?,
        "max_wave_bytes" => config.max_wave_bytes = value.extract()?,
        _ => return Err(PyTypeError::new_err("no such setting of a trace")),
    }
    Ok(())
}

/// `concrete`, `pec`, or relative permittivity and conductivity \[S/m\].
fn material(value: &Bound<'_, PyAny>) -> PyResult<Material> {
    if let Ok((relative_permittivity, conductivity_s_per_m)) = value.extract() {
        return Ok(Material::Dielectric {
            relative_permittivity,
            conductivity_s_per_m,
        });
    }
    match value.extract::<String>()?.as_str() {
        "concrete" => Ok(Material::Concrete),
        "pec" => Ok(Material::PerfectConductor),
        name => Err(PyValueError::new_err(format!(
            "material: '{name}' is neither 'concrete' nor 'pec' nor a pair (relative permittivity, conductivity in S/m)"
        ))),
    }
}
