//! Explanations of spectra.

use aps_report::explain::{Explained, Explanation};
use aps_report::link::LinkView;
use aps_report::picture::Outlines;
use map2aps::aps_label::LabelConfig;
use map2aps::aps_raytrace::glam::DVec2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::labels::LabelSettings;
use crate::paths::Paths;
use crate::scene::Scene;

/// The page, in HTML, that tells which path of one link makes which lobe of its spectrum.
#[pyfunction]
pub fn explain(
    py: Python<'_>,
    scene: &Bound<'_, Scene>,
    paths: &Bound<'_, Paths>,
    settings: LabelSettings,
    title: &str,
) -> PyResult<String> {
    let paths = paths.get();
    let [ends] = paths.ends_m[..] else {
        let links = paths.ends_m.len();
        let text = format!("paths: of {links} links, one can be explained at a time");
        return Err(PyValueError::new_err(text));
    };
    let link = LinkView::stored(ends.map(DVec2::from), &paths.table, 0);
    let config = settings.config(false)?;
    let scene = &scene.get().scene;
    py.detach(|| page(scene, &link, &config, title))
}

fn page(
    scene: &map2aps::aps_raytrace::Scene,
    link: &LinkView,
    config: &LabelConfig,
    title: &str,
) -> PyResult<String> {
    let protocol = config.protocol;
    let explanation = Explanation::of(link, protocol, config)
        .map_err(|error| PyValueError::new_err(format!("the link cannot be explained: {error}")))?;
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
