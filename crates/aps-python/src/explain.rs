//! Explanations of spectra.

use aps_report::explain::{Explained, Explanation};
use aps_report::link::LinkView;
use aps_report::picture::Outlines;
use map2aps::aps_label::{LabelConfig, Protocol};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::points;
use crate::labels::LabelSettings;
use crate::paths;
use crate::scene::Scene;

/// The page, in HTML, that tells which path of a link makes which lobe of its spectrum.
#[pyfunction]
pub fn explain(
    py: Python<'_>,
    scene: &Bound<'_, Scene>,
    ends: &Bound<'_, PyAny>,
    paths: &Bound<'_, PyAny>,
    settings: LabelSettings,
    title: &str,
) -> PyResult<String> {
    let ends: [_; 2] = points(ends, "ends")?.try_into().map_err(|_| {
        PyValueError::new_err("ends: a link has a transmitter and a receiver, shape (2, 2)")
    })?;
    let table = paths::table(paths)?;
    if table.links() != 1 {
        let text = format!(
            "paths: of {} links, one can be explained at a time",
            table.links()
        );
        return Err(PyValueError::new_err(text));
    }
    let config = settings.config(false)?;
    let scene = &scene.get().scene;
    py.detach(|| page(scene, &LinkView::stored(ends, &table, 0), &config, title))
}

fn page(
    scene: &map2aps::aps_raytrace::Scene,
    link: &LinkView,
    config: &LabelConfig,
    title: &str,
) -> PyResult<String> {
    let protocol: Protocol = config.protocol;
    let explanation = Explanation::of(link, protocol, config)
        .map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    let explanation = explanation.ok_or_else(|| {
        PyValueError::new_err(format!(
            "the link has no path that the {protocol} protocol counts"
        ))
    })?;
    let page = Explained {
        title,
        outlines: &Outlines::of_scene(scene),
        explanation: &explanation,
    };
    Ok(page.page().to_html())
}
