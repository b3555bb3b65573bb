//! Files to take along: the map, the link, its picture, its explanation, and the command line that gives the same.

use std::fmt::Display;
use std::path::Path;

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Area;
use aps_report::explain::{Explained, Explanation};
use aps_report::link::heading_words;
use hyper::StatusCode;
use map2aps::MapSource;
use map2aps::error::chain;
use map2aps::maps::{TileSettings, file_of, load_bytes};
use map2aps::path_list::{LinkEntry, LinkList};
use serde_json::{Value, json};
use xtask::{ArrayForm, command_line};

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
        "file/command" => text("text/plain; charset=utf-8", command(stock, question)?),
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
fn is_plain(city: &City) -> bool {
    city.area == Area::RADIOMAPSEER && city.houses.iter().all(|h| h.footprint.holes.is_empty())
}

/// The houses as they were given: polygons of RadioMapSeer, or GeoJSON in metres where there are courtyards or the square is
/// another.
fn map(city: &City) -> Value {
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

/// Makes sure that the command line reads a changed map as it is here.
fn must_be_read_back(
    stock: &Stock,
    city: &City,
    id: u32,
    tiles: TileSettings,
) -> Result<(), Fault> {
    let (text, file) = (map(city).to_string(), map_name(id));
    let (file, settings) = (Path::new(&file), stock.maps().scene);
    let read = load_bytes(text.as_bytes(), file, Some(0), tiles, settings);
    let (scene, _) = read.map_err(|error| {
        let why = chain(&error);
        Fault::NoFile(format!(
            "the command line cannot read the changed map: {why}"
        ))
    })?;
    match scene.walls() == city.scene.walls() {
        true => Ok(()),
        false => Err(Fault::NoFile(
            "a file holds the changed map with other walls: GeoJSON rounds to 1/1024 m and leaves out houses outside of the square"
                .into(),
        )),
    }
}

/// The file that the page saves a map as.
fn map_name(id: u32) -> String {
    format!("map-{id}.json")
}

/// The command lines that give the same paths and the same explanation.
fn command(stock: &Stock, question: &LinkQuestion) -> Result<String, Fault> {
    let config = question.trace.config()?;
    question.label.config()?;
    let maps = stock.maps();
    let id = question.city.map;
    let mut link: Vec<String> = Vec::new();
    match &maps.source {
        _ if !question.city.houses.is_empty() => {
            let city = stock.city(&question.city)?;
            let is_plain = is_plain(&city);
            let tiles = TileSettings {
                tile_m: city.area.max.x,
                metric: true,
                corner: Some([0.0; 2]),
                ..TileSettings::default()
            };
            must_be_read_back(stock, &city, id, tiles)?;
            option(&mut link, "--map", map_name(id));
            if !is_plain {
                option(&mut link, "--map-id", 0);
                option(&mut link, "--tile", tiles.tile_m);
                option(&mut link, "--corner", "0,0");
                link.push("--metric".into());
            }
        }
        MapSource::Folder(folder) => {
            let file = file_of(folder, id).map_err(map2aps::Error::from)?;
            option(&mut link, "--map", file.display());
        }
        MapSource::Synthetic { .. } => {
            option(&mut link, "--map", "synthetic");
            option(&mut link, "--seed", maps.seed.wrapping_add(u64::from(id)));
        }
        MapSource::City(city) => {
            let settings = city.settings();
            option(&mut link, "--map", city.file().display());
            option(&mut link, "--map-id", id);
            option(&mut link, "--tile", settings.tile_m);
            option(&mut link, "--min-buildings", settings.min_buildings);
            if let Some([x, y]) = settings.corner {
                option(&mut link, "--corner", format_args!("{x},{y}"));
            }
            if settings.metric {
                link.push("--metric".into());
            }
            if settings.all_polygons {
                link.push("--all-polygons".into());
            }
        }
        _ => {
            let text = "the command line does not read this kind of map";
            return Err(Fault::NoFile(text.into()));
        }
    }
    let ([a, b], [c, d]) = (question.tx, question.rx);
    option(&mut link, "--tx", format_args!("{a},{b}"));
    option(&mut link, "--rx", format_args!("{c},{d}"));
    option(&mut link, "--max-reflections", config.max_reflections);
    option(&mut link, "--max-diffractions", config.max_diffractions);
    option(&mut link, "--slope-diffraction", config.slope_diffraction);
    option(&mut link, "--frequency-hz", config.frequency_hz);
    option(&mut link, "--material", &question.trace.material);
    option(&mut link, "--close-gaps", maps.scene.close_gaps_m);
    match config.dynamic_range_db {
        Some(range_db) => option(&mut link, "--dynamic-range-db", range_db),
        None => link.push("--no-prune".into()),
    }
    let label = &question.label;
    let array = match label.array {
        ArrayForm::Ula => "ula",
        ArrayForm::Uca => "uca",
    };
    let mut explain = link.clone();
    option(&mut explain, "--protocol", label.protocol);
    option(&mut explain, "--array", array);
    option(&mut explain, "--elements", label.elements);
    option(&mut explain, "--spacing", label.spacing);
    option(&mut explain, "--heading", label.heading_deg);
    option(&mut explain, "--fs-hz", label.sampling_rate_hz);
    option(&mut explain, "--out", "link.html");
    let words = |first: &[&str]| first.iter().map(|&word| word.to_owned()).collect();
    let trace = [words(&["trace", "--format", "json"]), link].concat();
    let explain = [words(&["explain"]), explain].concat();
    Ok(format!(
        "{}\n{}\n",
        command_line::shown(trace),
        command_line::shown(explain)
    ))
}

/// Adds an option with its value.
fn option(words: &mut Vec<String>, name: &str, value: impl Display) {
    words.extend([name.to_owned(), value.to_string()]);
}
