//! Data sets.

use std::path::PathBuf;

use map2aps::maps::{SceneSettings, TileSettings};
use map2aps::settings::label_of;
use map2aps::{
    Control, Dataset, DatasetPlan, Error, MapSource, Receivers, Stored, relabel as relabel_paths,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Argument, Kind};
use crate::error::exception;
use crate::given::{Given, optional};
use crate::labels::LabelSettings;
use crate::maps::{Maps, tell_passed_over};
use crate::run::{run, run_owned};
use crate::tracer;

/// Settings that are not of labels and traces.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Settings<'py> {
    maps: Maps,
    map_ids: Option<Bound<'py, PyAny>>,
    tile_m: Option<Given<f64>>,
    metric: Given<bool>,
    all_polygons: Given<bool>,
    tx_per_map: Given<usize>,
    rx_per_map: Given<usize>,
    receivers: Given<String>,
    orientations: Given<u32>,
    seed: Given<u64>,
    store_pdp: Given<bool>,
    store_paths: Given<bool>,
}

/// Makes a data set in a folder, or goes on with it.
#[pyfunction]
#[pyo3(signature = (out, settings, label, progress, **limits))]
pub fn make_dataset(
    py: Python<'_>,
    out: PathBuf,
    settings: Settings<'_>,
    label: LabelSettings,
    progress: Option<Py<PyAny>>,
    limits: Option<&Bound<'_, PyDict>>,
) -> PyResult<()> {
    let trace = tracer::config(limits)?;
    let receivers: Receivers = settings
        .receivers
        .named("receivers")?
        .parse()
        .map_err(|e: map2aps::MapError| PyValueError::new_err(format!("receivers: {e}")))?;
    let map_ids = settings.map_ids.map(|ids| {
        let ids = Argument::new(&ids, "map_ids", Kind::Integer, &[None])?;
        ids.integers::<u32>()
    });
    let map_ids = map_ids.transpose()?;
    if map_ids.as_ref().is_some_and(Vec::is_empty) {
        return Err(PyValueError::new_err("map_ids: no map is chosen"));
    }
    let default = TileSettings::default();
    let tile_m = optional(settings.tile_m, "tile_m")?.unwrap_or(default.tile_m);
    if !(tile_m.is_finite() && tile_m > 0.0) {
        let text = format!("tile_m: {tile_m} is no side of maps in m");
        return Err(PyValueError::new_err(text));
    }
    let tiles = TileSettings {
        tile_m,
        metric: settings.metric.named("metric")?,
        all_polygons: settings.all_polygons.named("all_polygons")?,
        ..default
    };
    let store_pdp = settings.store_pdp.named("store_pdp")?;
    let source = settings.maps.source()?;
    let plan = DatasetPlan {
        tx_per_map: settings.tx_per_map.named("tx_per_map")?,
        rx_per_map: settings.rx_per_map.named("rx_per_map")?,
        receivers,
        label: label.config(store_pdp)?,
        stored: Stored {
            pdp: store_pdp,
            paths: settings.store_paths.named("store_paths")?,
            ..Stored::default()
        },
        seed: settings.seed.named("seed")?,
        scene: SceneSettings {
            orientations: settings.orientations.named("orientations")?,
            ..SceneSettings::default()
        },
        trace,
        ..DatasetPlan::default()
    };
    let maps = run_owned(py, move || source(tiles))?;
    match &maps {
        MapSource::City(city) => tell_passed_over(py, city, 2)?,
        _ => tiles
            .must_be_default()
            .map_err(|error| exception(Error::from(error)))?,
    }
    let made = |control: &Control<'_>| {
        let available = maps.ids()?;
        let ids = match &map_ids {
            Some(chosen) => map2aps::maps::choose(&available, chosen)?,
            None => available,
        };
        DatasetPlan { maps, ..plan }.make(&out, &ids, control)
    };
    run(py, progress.as_ref(), made).map(drop)
}

/// Labels the stored paths of the data set in `folder` anew, in the folder `out`; settings that are not given are those of its labels.
#[pyfunction]
#[pyo3(signature = (folder, out, label, store_pdp, store_paths, progress))]
pub fn relabel(
    py: Python<'_>,
    folder: PathBuf,
    out: PathBuf,
    label: LabelSettings,
    store_pdp: Option<Given<bool>>,
    store_paths: Option<Given<bool>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<()> {
    let source = run_owned(py, move || Ok(Dataset::open(folder)?))?;
    let own = source.manifest().layout.stored();
    let stored = Stored {
        pdp: optional(store_pdp, "store_pdp")?.unwrap_or(own.pdp),
        paths: optional(store_paths, "store_paths")?.unwrap_or(own.paths),
        ..own
    };
    let own = label_of(&source.manifest().configuration).map_err(exception)?;
    let label = label.over(&own, stored.pdp)?;
    let made = |control: &Control<'_>| relabel_paths(&source, &out, &label, stored, control);
    run(py, progress.as_ref(), made).map(drop)
}

/// The checked manifest of a data set, as JSON.
#[pyfunction]
pub fn manifest(py: Python<'_>, folder: PathBuf) -> PyResult<String> {
    run_owned(py, move || {
        let dataset = Dataset::open(&folder)?;
        Ok(serde_json::to_string(dataset.manifest())?)
    })
}
