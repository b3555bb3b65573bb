//! Tables as hubs of data sets take them: Parquet files of one row a link, with a card and a Croissant description.
//!
//! ```text
//! README.md                        the card
//! croissant.json
//! data/train/map_0000.parquet      one file a map; also data/develop, data/test
//! buildings.parquet                the image of each map's buildings
//! ```

mod card;
mod columns;
mod croissant;
mod file;
mod written;

use std::fs;
use std::path::Path;

use aps_data::{Dataset, MapData, Part, PathTable, Profile, replace_unsynced};

use super::folder::{Exported, create_folder};
use crate::control::{Control, Work};
use crate::dataset::{stored_paths, stored_pdp};
use crate::error::{At, Place, Result};
use crate::exchange::ExchangeError;
use columns::Column;
use written::Written;

/// Most bytes of numbers in a file, so that it stays below 500 MB whatever they compress to; further links of the map go to
/// further files.
const FILE_BYTES: usize = 400_000_000;

/// Rows of a group within a file.
const GROUP_ROWS: usize = 10_000;

/// Writes the tables of some maps, of at most `limit` links.
pub fn export(
    limit: Option<usize>,
    ids: &[u32],
    dataset: &Dataset,
    out: &Path,
    control: &Control<'_>,
) -> Result<Exported> {
    export_within(FILE_BYTES, limit, ids, dataset, out, control)
}

/// Writes the tables of some maps in files of at most so many bytes of numbers.
fn export_within(
    file_bytes: usize,
    limit: Option<usize>,
    ids: &[u32],
    dataset: &Dataset,
    out: &Path,
    control: &Control<'_>,
) -> Result<Exported> {
    if let Some(&id) = ids.iter().find(|&&id| i32::try_from(id).is_err()) {
        return Err(ExchangeError::NoRoomForMap(id).into());
    }
    let maps = dataset.manifest().maps.iter();
    let maps = maps.filter(|map| ids.contains(&map.id));
    let links: usize = maps.map(|map| map.links).sum();
    let most = limit.unwrap_or(usize::MAX);
    control.progress.begin(Work {
        units: links.min(most) as u64,
        name: "links",
        finished_maps: 0,
        maps: ids.len(),
    });
    let (mut left, mut written, mut described) = (most, Vec::new(), Vec::new());
    let mut images = Vec::new();
    for &id in ids {
        control.check()?;
        control.progress.map(id);
        let map = dataset.map(id)?;
        let part = dataset.manifest().split.part_of(id);
        images.push((id, part, map.buildings.clone()));
        let rows = left.min(map.links.len());
        left -= rows;
        let table = Table {
            pdp: stored_pdp(dataset, id)?,
            paths: stored_paths(dataset, id)?,
            map,
        };
        let folder = format!("data/{}", columns::folder_of(part));
        create_folder(&out.join(&folder))?;
        for (number, rows) in table.portions(rows, file_bytes).into_iter().enumerate() {
            let suffix = match number {
                0 => String::new(),
                _ => format!("-{number}"),
            };
            let name = format!("{folder}/map_{id:04}{suffix}.parquet");
            let firsts = rows.clone().step_by(GROUP_ROWS);
            let groups = firsts.map(|first| table.columns(first..rows.end.min(first + GROUP_ROWS)));
            let make = || file::bytes("link", groups);
            let file = Written::make(out, name, part, rows.len(), make)?;
            written.push(file);
            control.progress.advance(rows.len() as u64);
        }
        if described.is_empty() {
            described = table.columns(0..0);
        }
    }
    remove_others(out, ids, &written)?;
    // Small, and of another split although of as many rows: it is never kept.
    let name = "buildings.parquet";
    let shown = file::bytes("map", std::iter::once(columns::of_images(&images)))?;
    replace_unsynced(&out.join(name), &shown)?;
    let shown = Written::of(name.into(), None, ids.len(), &shown);
    let about = card::About {
        dataset,
        written: &written,
        columns: &described,
        buildings: &columns::of_images(&[]),
        links: links.min(most),
    };
    let bytes = written.iter().map(|file| file.bytes).sum::<u64>() + shown.bytes;
    replace_unsynced(&out.join("README.md"), about.card().as_bytes())?;
    let croissant = serde_json::to_vec_pretty(&croissant::description(&about, &shown))?;
    replace_unsynced(&out.join("croissant.json"), &croissant)?;
    Ok(Exported {
        links: links.min(most),
        bytes,
    })
}

/// Removes tables of these maps that an export of more links, or of another split, left.
fn remove_others(out: &Path, ids: &[u32], written: &[Written]) -> Result<()> {
    for part in Part::ALL.map(Some).into_iter().chain([None]) {
        let folder = format!("data/{}", columns::folder_of(part));
        let entries = match fs::read_dir(out.join(&folder)) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => continue,
            Err(error) => return Err(error).at_file(Place::Reading, &out.join(folder)),
        };
        for entry in entries {
            let entry = entry.at_file(Place::Reading, &out.join(&folder))?;
            let file = entry.file_name();
            let Some(file) = file.to_str() else { continue };
            let is_of_map = map_of(file).is_some_and(|id| ids.contains(&id));
            let name = format!("{folder}/{file}");
            if is_of_map && written.iter().all(|written| written.name != name) {
                fs::remove_file(entry.path()).at_file(Place::Removing, &entry.path())?;
            }
        }
    }
    Ok(())
}

/// Reads the map's id from the name of a table.
fn map_of(file: &str) -> Option<u32> {
    let number = file.strip_prefix("map_")?.strip_suffix(".parquet")?;
    number.split('-').next()?.parse().ok()
}

/// The links of one map.
struct Table {
    map: MapData,
    pdp: Option<Profile>,
    paths: Option<PathTable>,
}

impl Table {
    /// Cuts the first links into portions of at most so many bytes of numbers, or of one link that has more; at least one
    /// portion, so that no map is missing.
    fn portions(&self, rows: usize, most_bytes: usize) -> Vec<std::ops::Range<usize>> {
        let bins =
            |profile: &Profile| 4 * profile.bins() * if profile.argmax().is_some() { 2 } else { 1 };
        let of_spectra: usize = self.map.aps.iter().chain(&self.pdp).map(bins).sum();
        let (mut portions, mut first, mut bytes) = (Vec::new(), 0, 0);
        for row in 0..rows {
            let paths = self.paths.as_ref();
            let paths = paths.map_or(0, |paths| paths.paths_of(row).len());
            let row_bytes = 100 + of_spectra + 5 * 8 * paths;
            if bytes + row_bytes > most_bytes && row > first {
                portions.push(first..row);
                (first, bytes) = (row, 0);
            }
            bytes += row_bytes;
        }
        if first < rows {
            portions.push(first..rows);
        }
        portions
    }

    /// The columns of some links.
    fn columns(&self, rows: std::ops::Range<usize>) -> Vec<Column> {
        columns::of_links(&self.map, self.pdp.as_ref(), self.paths.as_ref(), rows)
    }
}

#[cfg(test)]
mod tests;
