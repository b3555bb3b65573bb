//! Files to take along: the map, the link, its picture, its explanation, and the command line that gives the same.

use std::fmt::Display;

use aps_raytrace::Footprint;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Area, Coordinates, GeoJsonConfig, Tiling, parse_geojson};
use aps_report::explain::{Explained, Explanation};
use aps_report::link::from_heading;
use hyper::StatusCode;
use map2aps::MapSource;
use map2aps::path_list::{LinkEntry, LinkList};
use serde_json::{Value, json};
use xtask::{ArrayForm, command_line};

use crate::fault::Fault;
use crate::houses::House;
use crate::link::Traced;
use crate::reply::{JSON, Reply, whole};
use crate::request::LinkQuestion;
use crate::stock::{City, Stock};
use crate::ticket::Ticket;

const NAMES: [&str; 5] = [
    "file/map",
    "file/paths",
    "file/picture",
    "file/explanation",
    "file/command",
];

/// The name of the file that a path names.
pub fn named(path: &str) -> Option<&'static str> {
    NAMES.into_iter().find(|&name| name == path)
}

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
        "file/map" => text(JSON, map(&*stock.city(&question.city)?)?.to_string()),
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
    let title = format!(
        "Map {}, from ({a}, {b}) m to ({c}, {d}) m",
        question.city.map
    );
    title + &from_heading(question.label.heading_deg)
}

/// Returns true for a map that RadioMapSeer's format holds: polygons without holes in its square.
fn is_plain(city: &City) -> bool {
    city.area == Area::RADIOMAPSEER && city.houses.iter().all(|h| h.footprint.holes.is_empty())
}

/// The houses as they were given: polygons of RadioMapSeer, or GeoJSON in metres where there are courtyards or the square is
/// another.
fn map(city: &City) -> Result<Value, Fault> {
    let ring =
        |ring: &Vec<DVec2>| -> Vec<[f64; 2]> { closed(ring).map(|p| p.to_array()).collect() };
    if is_plain(city) {
        let rings = city.houses.iter().map(|h| ring(&h.footprint.outer));
        return Ok(rings.collect());
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
    let features: Vec<Value> = features.collect();
    Ok(json!({ "type": "FeatureCollection", "features": features }))
}

/// The vertices of a ring, the first again last.
fn closed(ring: &[DVec2]) -> impl Iterator<Item = &DVec2> {
    let is_closed = ring.first() == ring.last();
    ring.iter().chain(ring.first().filter(|_| !is_closed))
}

/// Returns true when the command line reads a map in GeoJSON as it is here: no house lies outside of the square, and no corner
/// between the parts of a metre that coordinates are rounded to.
fn is_read_back(city: &City, map: &Value) -> bool {
    let config = GeoJsonConfig {
        coordinates: Coordinates::Metres,
        origin: Some([0.0; 2]),
        ..GeoJsonConfig::default()
    };
    let side_m = city.area.max.x;
    let square = Area {
        min: DVec2::ZERO,
        max: DVec2::splat(side_m),
    };
    let read = parse_geojson(map.to_string(), &config).ok();
    let cut = read.and_then(|c| Tiling::from_corner(c.footprints, side_m, DVec2::ZERO).ok());
    let is_same = |(read, own): (&Footprint, &House)| {
        let ([a, b], [c, d]) = (
            [read, &own.footprint].map(|f| &f.outer),
            [read, &own.footprint].map(|f| &f.holes),
        );
        let same = |a: &[DVec2], b: &[DVec2]| closed(a).eq(closed(b));
        same(a, b) && c.len() == d.len() && c.iter().zip(d).all(|(c, d)| same(c, d))
    };
    cut.and_then(|cut| cut.tile(0)).is_some_and(|tile| {
        let is_complete = tile.footprints.len() == city.houses.len();
        city.area == square && is_complete && tile.footprints.iter().zip(&city.houses).all(is_same)
    })
}

/// The command lines that give the same paths and the same explanation.
fn command(stock: &Stock, question: &LinkQuestion) -> Result<String, Fault> {
    let config = question.trace.config()?;
    let maps = stock.maps();
    let id = question.city.map;
    let mut link: Vec<String> = Vec::new();
    let mut option = |name: &str, value: &dyn Display| {
        link.extend([name.to_owned(), value.to_string()]);
    };
    match &maps.source {
        _ if !question.city.houses.is_empty() => {
            let city = stock.city(&question.city)?;
            option("--map", &format_args!("map-{id}.json"));
            if !is_plain(&city) {
                if !is_read_back(&city, &map(&city)?) {
                    return Err(Fault::NoFile(
                        "no file of a map with courtyards, or of another square than 256 m, holds a house outside of the square or \
                        a corner between 1/1024 m",
                    ));
                }
                option("--tile", &city.area.max.x);
                option("--corner", &"0,0");
                link.push("--metric".into());
            }
        }
        MapSource::Folder(folder) => {
            let file = folder.join(format!("{id}.json"));
            option("--map", &file.display());
        }
        MapSource::Synthetic { .. } => {
            option("--map", &"synthetic");
            option("--seed", &maps.seed.wrapping_add(u64::from(id)));
        }
        MapSource::City(city) => {
            let settings = city.settings();
            option("--map", &city.file().display());
            option("--map-id", &id);
            option("--tile", &settings.tile_m);
            option("--min-buildings", &settings.min_buildings);
            if let Some([x, y]) = settings.corner {
                option("--corner", &format_args!("{x},{y}"));
            }
            if settings.metric {
                link.push("--metric".into());
            }
            if settings.all_polygons {
                link.push("--all-polygons".into());
            }
        }
        _ => {
            return Err(Fault::NoFile(
                "the command line does not read this kind of map",
            ));
        }
    }
    let mut option = |name: &str, value: &dyn Display| {
        link.extend([name.to_owned(), value.to_string()]);
    };
    let ([a, b], [c, d]) = (question.tx, question.rx);
    option("--tx", &format_args!("{a},{b}"));
    option("--rx", &format_args!("{c},{d}"));
    option("--max-reflections", &config.max_reflections);
    option("--max-diffractions", &config.max_diffractions);
    option("--slope-diffraction", &config.slope_diffraction);
    option("--frequency-hz", &config.frequency_hz);
    option("--material", &question.trace.material);
    option("--close-gaps", &maps.scene.close_gaps_m);
    match config.dynamic_range_db {
        Some(range_db) => option("--dynamic-range-db", &range_db),
        None => link.push("--no-prune".into()),
    }
    let label = &question.label;
    let array = match label.array {
        ArrayForm::Ula => "ula",
        ArrayForm::Uca => "uca",
    };
    let spectrum = [
        ("--protocol", label.protocol.to_string()),
        ("--array", array.into()),
        ("--elements", label.elements.to_string()),
        ("--spacing", label.spacing.to_string()),
        ("--heading", label.heading_deg.to_string()),
        ("--fs-hz", label.sampling_rate_hz.to_string()),
        ("--out", "link.html".into()),
    ];
    let spectrum = spectrum.map(|(name, value)| [name.to_owned(), value]);
    let words = |first: &[&str]| {
        first
            .iter()
            .map(|&word| word.to_owned())
            .collect::<Vec<_>>()
    };
    let trace = [words(&["trace", "--format", "json"]), link.clone()].concat();
    let explain = [words(&["explain"]), link, spectrum.concat()].concat();
    Ok(format!(
        "{}\n{}\n",
        command_line::shown(trace),
        command_line::shown(explain)
    ))
}
