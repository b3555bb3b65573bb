//! Files to take along: the map, the link, its picture, its explanation, and the command lines that give the same.

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Area;
use aps_report::explain::{Explained, Explanation};
use aps_report::link::heading_words;
use hyper::StatusCode;
use map2aps::path_list::{LinkEntry, LinkList};
use serde_json::{Value, json};

use crate::command;
use crate::fault::Fault;
use crate::link::Traced;
use crate::reply::{JSON, Reply, whole};
use crate::request::LinkQuestion;
use crate::stock::{City, Stock};
use crate::ticket::Ticket;

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
    stock: &Stock,
    question: &LinkQuestion,
    ticket: &Ticket,
) -> Result<Reply, Fault> {
    let text = |media_type, text: String| Ok(whole(StatusCode::OK, media_type, text));
    match name {
        "file/map" => text(JSON, map(&*stock.city(&question.city)?).to_string()),
        "file/command" => text(
            "text/plain; charset=utf-8",
            command::lines(stock, question)?,
        ),
        "file/paths" => {
            let traced = Traced::new(stock, question, ticket)?;
            let view = &traced.view;
            let list = LinkList {
                links: vec![LinkEntry::new(view.tx, view.rx, &traced.link.paths)],
            };
            let list = serde_json::to_string_pretty(&list).map_err(|_| Fault::Broken)?;
            text(JSON, list + "\n")
        }
        _ => {
            let traced = Traced::new(stock, question, ticket)?;
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

/// Returns true for a map that RadioMapSeer's format holds: polygons without holes in its square.
pub fn is_plain(city: &City) -> bool {
    city.area == Area::RADIOMAPSEER && city.houses.iter().all(|h| h.footprint.holes.is_empty())
}

/// The houses as they were given: polygons of RadioMapSeer, or GeoJSON in metres where there are courtyards or the square is
/// another.
pub fn map(city: &City) -> Value {
    let ring = |ring: &Vec<DVec2>| -> Vec<[f64; 2]> {
        let is_closed = ring.first() == ring.last();
        let again = ring.first().filter(|_| !is_closed);
        let closed = ring.iter().chain(again);
        closed.map(|p| p.to_array()).collect()
    };
    if is_plain(city) {
        let rings = city.houses.iter().map(|h| ring(&h.footprint.outer));
        return rings.collect();
    }
    let features = city.houses.iter().map(|house| {
        let rings = std::iter::once(&house.footprint.outer).chain(&house.footprint.holes);
        let rings: Vec<_> = rings.map(ring).collect();
        json!({
            "type": "Feature",
            "properties": { "building": "yes" },
            "geometry": { "type": "Polygon", "coordinates": rings },
        })
    });
    json!({ "type": "FeatureCollection", "features": features.collect::<Value>() })
}

/// The file that the page saves a map as.
pub fn map_name(id: u32) -> String {
    format!("map-{id}.json")
}
