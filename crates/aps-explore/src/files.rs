//! Files to take along: the map, the link, its picture, its explanation, and the command lines that give the same.

use aps_report::explain::{Explained, Explanation};
use aps_report::link::heading_words;
use hyper::StatusCode;
use map2aps::path_list::{LinkEntry, LinkList};

use crate::cache::Cache;
use crate::command;
use crate::fault::Fault;
use crate::link::Traced;
use crate::map_file::map;
use crate::reply::{JSON, Reply, whole};
use crate::request::LinkQuestion;
use crate::request_handle::RequestHandle;

/// The names of the files.
pub const NAMES: [&str; 5] = [
    "file/map",
    "file/paths",
    "file/picture",
    "file/explanation",
    "file/command",
];

/// Makes a file.
///
/// # Errors
/// As for a link; a map or link that no file of that kind holds.
pub fn make(
    name: &str,
    cache: &Cache,
    question: &LinkQuestion,
    handle: &RequestHandle,
) -> Result<Reply, Fault> {
    let text = |media_type, text: String| Ok(whole(StatusCode::OK, media_type, text));
    match name {
        "file/map" => text(JSON, map(&*cache.city(&question.city)?).to_string()),
        "file/command" => text(
            "text/plain; charset=utf-8",
            command::lines(cache, question)?,
        ),
        "file/paths" => {
            let traced = Traced::new(cache, question, handle)?;
            let view = &traced.view;
            let list = LinkList {
                links: vec![LinkEntry::new(view.tx, view.rx, &traced.link.paths)],
            };
            let list = serde_json::to_string_pretty(&list).map_err(|_| Fault::Broken)?;
            text(JSON, list + "\n")
        }
        _ => {
            let traced = Traced::new(cache, question, handle)?;
            let label = question.label.config()?;
            let protocol = question.label.protocol;
            let explanation = Explanation::of(&traced.view, protocol, &label)?;
            let explanation = explanation.ok_or(Fault::NoSpectrum)?;
            let title = title(question);
            let explained = Explained {
                title: &title,
                outlines: &traced.city.outlines,
                explanation: &explanation,
            };
            match name {
                "file/picture" => text("image/svg+xml", explained.drawing().to_file_text()),
                _ => text("text/html; charset=utf-8", explained.page().to_html()),
            }
        }
    }
}

fn title(question: &LinkQuestion) -> String {
    let ([a, b], [c, d]) = (question.tx, question.rx);
    let map = question.city.map;
    let title = format!("Map {map}, from ({a}, {b}) m to ({c}, {d}) m");
    title + &heading_words(question.label.heading_deg)
}
