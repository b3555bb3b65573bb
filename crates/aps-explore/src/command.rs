//! The command lines of the runner that give the same link.

use std::fmt::Display;
use std::path::Path;

use aps_report::command_line;
use map2aps::MapSource;
use map2aps::error::chain;
use map2aps::maps::{TileSettings, file_of, load_bytes};

use crate::cache::{Cache, City};
use crate::fault::Fault;
use crate::map_file::{is_plain, map, map_name};
use crate::request::LinkQuestion;

/// The command lines that give the same paths and the same explanation.
///
/// # Errors
/// Settings out of range, and a map that no file of the command line holds.
pub fn lines(cache: &Cache, question: &LinkQuestion) -> Result<String, Fault> {
    let config = question.trace.config()?;
    question.label.config()?;
    let maps = cache.maps();
    let id = question.city.map;
    let mut link: Vec<String> = Vec::new();
    match &maps.source {
        _ if !question.city.houses.is_empty() => {
            let city = cache.city(&question.city)?;
            let is_plain = is_plain(&city);
            let tiles = match is_plain {
                true => TileSettings::default(),
                false => TileSettings {
                    tile_m: city.area.max.x,
                    metric: true,
                    corner: Some([0.0; 2]),
                    ..TileSettings::default()
                },
            };
            must_be_read_back(cache, &city, id, tiles)?;
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
    let mut explain = link.clone();
    option(&mut explain, "--protocol", label.protocol);
    option(&mut explain, "--array", label.array.name());
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

/// Makes sure that the command line reads a changed map as it is here.
fn must_be_read_back(
    cache: &Cache,
    city: &City,
    id: u32,
    tiles: TileSettings,
) -> Result<(), Fault> {
    let (text, file) = (map(city).to_string(), map_name(id));
    let (file, settings) = (Path::new(&file), cache.maps().scene);
    let tile = (!is_plain(city)).then_some(0);
    let read = load_bytes(text.as_bytes(), file, tile, tiles, settings);
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
