//! The files of the page, in the program itself.

use aps_label::{ArrayForm, LabelConfig, Protocol};
use aps_raytrace::TraceConfig;
use aps_report::theme;
use hyper::StatusCode;
use serde::Serialize;

use crate::reply::{Reply, whole};

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";

/// Path, media type and text of every file.
const FILES: [(&str, &str, &str); 11] = [
    ("/", HTML, include_str!("../page/index.html")),
    ("/style.css", CSS, include_str!("../page/style.css")),
    ("/main.js", SCRIPT, include_str!("../page/main.js")),
    ("/state.js", SCRIPT, include_str!("../page/state.js")),
    ("/ask.js", SCRIPT, include_str!("../page/ask.js")),
    ("/city.js", SCRIPT, include_str!("../page/city.js")),
    ("/charts.js", SCRIPT, include_str!("../page/charts.js")),
    ("/tables.js", SCRIPT, include_str!("../page/tables.js")),
    ("/coverage.js", SCRIPT, include_str!("../page/coverage.js")),
    ("/houses.js", SCRIPT, include_str!("../page/houses.js")),
    ("/settings.js", SCRIPT, include_str!("../page/settings.js")),
];

/// The file at a path.
pub fn file(path: &str) -> Option<Reply> {
    if path == "/theme.css" {
        let css = theme::variables_css() + &theme::picture_css();
        return Some(whole(StatusCode::OK, CSS, css));
    }
    if path == "/defaults.js" {
        return Some(whole(StatusCode::OK, SCRIPT, defaults()));
    }
    let found = FILES.iter().find(|file| file.0 == path);
    found.map(|&(_, media_type, text)| whole(StatusCode::OK, media_type, text))
}

/// The settings that the page begins with, named as it names them: the defaults of the command line.
#[derive(Serialize)]
struct Defaults {
    reflections: usize,
    diffractions: usize,
    slopes: &'static str,
    range: Option<f64>,
    frequency: f64,
    material: &'static str,
    protocol: Protocol,
    array: ArrayForm,
    elements: usize,
    spacing: f64,
    heading: f64,
    bandwidth: f64,
}

fn defaults() -> String {
    let (trace, label) = (TraceConfig::default(), LabelConfig::paper());
    let (array, elements, spacing) = label.array.parts();
    let defaults = Defaults {
        reflections: trace.max_reflections,
        diffractions: trace.max_diffractions,
        slopes: if trace.slope_diffraction { "on" } else { "off" },
        range: trace.dynamic_range_db,
        frequency: trace.frequency_hz,
        material: "concrete",
        protocol: label.protocol,
        array,
        elements,
        spacing,
        heading: 0.0,
        bandwidth: label.sampling_rate_hz,
    };
    let json = serde_json::to_string(&defaults).expect("numbers and words are JSON");
    format!("export default {json};\n")
}
