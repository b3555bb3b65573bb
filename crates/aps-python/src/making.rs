//! Data sets.

use std::path::PathBuf;

use map2aps::maps::TileSettings;
use map2aps::{Control, Dataset, DatasetPlan, MapSource, Receivers, Stored};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::exception;
use crate::labels::LabelSettings;
use crate::run::run;
use crate::tracer;

/// Source of maps.
#[derive(FromPyObject)]
pub enum Maps {
    /// Number of synthetic cities.
    #[pyo3(transparent)]
    Synthetic(u32),
    /// A folder of RadioMapSeer files, or the GeoJSON file of a city.
    #[pyo3(transparent)]
    Path(PathBuf),
}

/// Settings that are not of labels and traces.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Settings {
    maps: Maps,
    map_ids: Option<Vec<u32>>,
    tile_m: Option<f64>,
    metric: bool,
    tx_per_map: usize,
    rx_per_map: usize,
    receivers: String,
    seed: u64,
    store_pdp: bool,
    store_paths: bool,
}

impl Settings {
    fn source(&self) -> Result<MapSource, map2aps::Error> {
        match &self.maps {
            Maps::Synthetic(count) => Ok(MapSource::Synthetic { count: *count }),
            Maps::Path(path) if path.is_dir() => Ok(MapSource::Folder(path.clone())),
            Maps::Path(path) => {
                let default = TileSettings::default();
                let tiles = TileSettings {
                    tile_m: self.tile_m.unwrap_or(default.tile_m),
                    metric: self.metric,
                    ..default
                };
                MapSource::geojson(path, tiles)
            }
        }
    }
}

/// Makes a data set in a folder, or goes on with it.
#[pyfunction]
#[pyo3(signature = (out, settings, label, progress, **limits))]
pub fn make_dataset(
    py: Python<'_>,
    out: PathBuf,
    settings: Settings,
    label: LabelSettings,
    progress: Option<Py<PyAny>>,
    limits: Option<&Bound<'_, PyDict>>,
) -> PyResult<()> {
    let trace = tracer::config(limits)?;
    let receivers: Receivers = settings
        .receivers
        .parse()
        .map_err(|e: map2aps::MapError| exception(e))?;
    let label = label.config(settings.store_pdp)?;
    let made = |control: &Control<'_>| {
        let maps = settings.source()?;
        let available = maps.ids()?;
        let ids = match &settings.map_ids {
            Some(chosen) => map2aps::maps::choose(&available, chosen)?,
            None => available,
        };
        let plan = DatasetPlan {
            maps,
            tx_per_map: settings.tx_per_map,
            rx_per_map: settings.rx_per_map,
            receivers,
            label,
            stored: Stored {
                pdp: settings.store_pdp,
                paths: settings.store_paths,
                ..Stored::default()
            },
            seed: settings.seed,
            trace,
            ..DatasetPlan::default()
        };
        plan.make(&out, &ids, control)
    };
    run(py, progress.as_ref(), made).map(drop)
}

/// The checked manifest of a data set, as JSON.
#[pyfunction]
pub fn manifest(py: Python<'_>, folder: PathBuf) -> PyResult<String> {
    run(py, None, |_| {
        let dataset = Dataset::open(&folder)?;
        Ok(serde_json::to_string(dataset.manifest())?)
    })
}
