//! Checks a map's arrays: by themselves, and beside the map they were made from.

use aps_data::{Dataset, MapData, MapEntry};
use aps_raytrace::Scene;
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Location;
use serde_json::Value;

use super::findings::Findings;
use crate::dataset::stored_paths;
use crate::error::Result;
use crate::maps::identity::{Kept, is_origin_alone};
use crate::settings;
use crate::tally::Tally;

/// Ends of valid links that are named; more of them are only counted.
const NAMED: usize = 10;

/// Runs the checks that need the data set alone. `is_exact`: ends are checked beside the map instead.
pub fn check(
    dataset: &Dataset,
    entry: &MapEntry,
    map: &MapData,
    is_exact: bool,
    findings: &mut Findings<'_>,
) -> Result<()> {
    check_counts(dataset, entry, findings)?;
    check_statistics(dataset, entry, map, findings)?;
    if !is_exact {
        let is_wrong = |p: [f64; 2]| match map.buildings.grid().holds(p) {
            true => map.buildings.is_deep_inside(p).then_some("in a building"),
            false => Some("outside the map"),
        };
        check_ends(map, is_wrong, findings);
    }
    Ok(())
}

/// Checks beside the map that the data set was made of; returns false when the map given is another.
pub fn check_against(
    dataset: &Dataset,
    map: &MapData,
    given: &Scene,
    findings: &mut Findings<'_>,
) -> Result<bool> {
    if !Kept::new(dataset, map.id, map.buildings.clone()).is_of(given)? {
        findings.add(format!(
            "map {}: buildings are not those of the map given",
            map.id
        ));
        return Ok(false);
    }
    check_pixels(map, given, findings);
    let is_wrong = |p: [f64; 2]| match given.locate(DVec2::from(p)) {
        Location::Outdoor => None,
        Location::OnWall { .. } => Some("on a wall"),
        Location::OutsideArea => Some("outside the map"),
        Location::Inside { .. } => Some("in a building"),
    };
    check_ends(map, is_wrong, findings);
    Ok(true)
}

/// Pixels that show another city than the one traced: each is set where its part of the row touches a building of the scene.
fn check_pixels(map: &MapData, scene: &Scene, findings: &mut Findings<'_>) {
    let grid = map.buildings.grid();
    let pixels = (0..grid.height).flat_map(|y| (0..grid.width).map(move |x| (x, y)));
    let is_wrong = |&(x, y): &(usize, usize)| {
        let at = |dx: f64| DVec2::new(x as f64 + dx, y as f64) * grid.metres_per_pixel;
        scene.touches_building(at(-0.5), at(0.5)) != (map.buildings.row(y)[x] == 1)
    };
    let wrong: Vec<(usize, usize)> = pixels.filter(is_wrong).collect();
    if let Some((x, y)) = wrong.first() {
        let (id, n) = (map.id, wrong.len());
        findings.add(format!(
            "map {id}: {n} pixels are not as the buildings traced, the first at column {x}, row {y}"
        ));
    }
}

/// Numbers of terminals and links that contradict the settings.
fn check_counts(dataset: &Dataset, entry: &MapEntry, findings: &mut Findings<'_>) -> Result<()> {
    let Some((sampling, _)) = settings::tracing_of(&dataset.manifest().configuration)? else {
        return Ok(());
    };
    let (tx, rx) = (sampling.tx_per_map, sampling.rx_per_map);
    let links = tx.saturating_mul(rx);
    let missing = entry.statistics["missing_links"].as_u64().unwrap_or(0);
    let counted = missing.saturating_add(entry.links as u64);
    let is_right = entry.tx == tx && sampling.pool().contains(&entry.rx) && counted == links as u64;
    if !is_right {
        let (t, r, l) = (entry.tx, entry.rx, entry.links);
        let (from, to) = sampling.pool().into_inner();
        findings.add(format!(
            "map {}: {t} transmitters, {r} receivers, {l} links and {missing} missing; its settings make {tx}, {from} to \
             {to}, {links}",
            entry.id
        ));
    }
    Ok(())
}

/// Ends of labelled links where nothing can stand.
fn check_ends(
    map: &MapData,
    is_wrong: impl Fn([f64; 2]) -> Option<&'static str>,
    findings: &mut Findings<'_>,
) {
    for (role, ends, of_link) in [("tx", &map.tx_m, 0), ("rx", &map.rx_m, 1)] {
        let mut valid_links = vec![0; ends.len()];
        for link in map.valid_links() {
            valid_links[map.links[link][of_link] as usize] += 1;
        }
        let wrong = (0..ends.len())
            .filter(|&i| valid_links[i] > 0)
            .filter_map(|i| Some((i, is_wrong(ends[i])?)));
        let wrong: Vec<(usize, &str)> = wrong.collect();
        for &(i, place) in wrong.iter().take(NAMED) {
            let ([x, y], links) = (ends[i], valid_links[i]);
            findings.add(format!(
                "map {}: {role} {i}, which has {links} valid links, is {place}, at ({x}, {y}) m",
                map.id
            ));
        }
        if wrong.len() > NAMED {
            let more = wrong.len() - NAMED;
            findings.add(format!("map {}: so are {more} more {role}", map.id));
        }
    }
}

/// Statistics of the manifest that are not those of the arrays: numbers of paths and peaks, and the mean and deviation
/// that spectra are normalised by.
fn check_statistics(
    dataset: &Dataset,
    entry: &MapEntry,
    map: &MapData,
    findings: &mut Findings<'_>,
) -> Result<()> {
    let manifest = dataset.manifest();
    // Imported data tell no more than their source.
    let stored = match &entry.statistics {
        Value::Object(stored) if !is_origin_alone(stored) => stored,
        _ => return Ok(()),
    };
    let mut tally = Tally::default();
    if let (Some(aps), Ok(label)) = (&map.aps, settings::label_of(&manifest.configuration)) {
        tally.shapes(aps, map.valid_links(), label.protocol)?;
    }
    let paths = stored_paths(dataset, map.id)?;
    for (link, &status) in map.status.iter().enumerate() {
        let count = paths.as_ref().map_or(0, |paths| paths.paths_of(link).len());
        tally.stored_link(count, status, map.fallback[link]);
    }
    let found = tally.statistics();
    let checked = [
        ("paths", manifest.layout.paths),
        ("dominant_peaks", map.aps.is_some()),
        ("relative_power", map.aps.is_some()),
        ("fallback_diffractions", true),
    ];
    for (name, is_stored) in checked {
        let differs = stored.get(name).is_some_and(|s| Some(s) != found.get(name));
        if is_stored && differs {
            let (stored, found) = (&stored[name], &found[name]);
            findings.add(format!(
                "map {}: statistics.{name} is {stored}, its arrays make {found}",
                map.id
            ));
        }
    }
    Ok(())
}
