//! The files of the page, in the program itself.

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
    let found = FILES.iter().find(|file| file.0 == path);
    found.map(|&(_, media_type, text)| whole(StatusCode::OK, media_type, text))
}
