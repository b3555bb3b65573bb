//! The files of the page, in the program itself.

use aps_label::LabelConfig;
use aps_raytrace::TraceConfig;
use aps_report::theme;
use hyper::StatusCode;

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

/// Defaults of the command line as a module of the page, named as its settings are.
fn defaults() -> String {
    let (trace, label) = (TraceConfig::default(), LabelConfig::paper());
    let (array, elements, spacing) = label.array.parts();
    let slopes = if trace.slope_diffraction { "on" } else { "off" };
    let range_db = trace.dynamic_range_db.map(|range_db| range_db.to_string());
    format!(
        "export default {{ reflections: {}, diffractions: {}, slopes: '{slopes}', range: {}, frequency: {}, material: 'concrete', \
         protocol: '{}', array: '{array}', elements: {elements}, spacing: {spacing}, heading: 0, bandwidth: {} }};\n",
        trace.max_reflections,
        trace.max_diffractions,
        range_db.as_deref().unwrap_or("null"),
        trace.frequency_hz,
        label.protocol,
        label.sampling_rate_hz
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_module_that_the_page_imports_is_served() {
        let imports = FILES
            .iter()
            .flat_map(|(.., text)| text.split("from '.").skip(1));
        for import in imports {
            let (path, _) = import.split_once('\'').unwrap();
            assert!(file(path).is_some(), "{path}");
        }
    }
}
