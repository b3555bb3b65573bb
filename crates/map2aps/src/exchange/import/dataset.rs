//! Files of maps made into a data set.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use aps_data::{DatasetConfig, DatasetWriter, LinkRows, Totals, sha256_of};
use serde_json::Value;

use crate::control::{Control, Work};
use crate::dataset::or_kept;
use crate::error::{At, Place, Result};
use crate::exchange::ExchangeError;
use crate::maps::identity::{self, SOURCE};
use crate::maps::{MapError, MapSource, SceneSettings, split_of_imported};

/// Links that a thread reads at a time.
pub const LINKS_AT_ONCE: usize = 64;

/// Result of an import.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Imported {
    /// Sums over the data set.
    pub totals: Totals,
    /// Entries that are no links or paths.
    pub left_out: LeftOut,
}

/// Counts of entries that are left out, by the reason.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct LeftOut {
    /// Paths with a number that is not finite.
    pub not_finite: usize,
    /// Paths with an impossible loss or delay.
    pub impossible: usize,
    /// Receivers at the place of an earlier one.
    pub repeated_receivers: usize,
}

/// Makes those of the maps that are not there, and finishes the data set.
pub fn make<T: AsRef<Path>>(
    out: &Path,
    config: DatasetConfig,
    maps: &BTreeMap<u32, Vec<T>>,
    given: Option<&MapSource>,
    control: &Control<'_>,
    mut map: impl FnMut(&DatasetWriter, u32, &[T]) -> Result<()>,
) -> Result<Imported> {
    let seed = config.seed;
    let writer = DatasetWriter::open(out, config).at_file(Place::Dataset, out)?;
    for (&id, files) in maps {
        control.check()?;
        let Some(there) = writer.entry(id) else {
            continue;
        };
        let other = |what: &str| MapError::OtherSource {
            id,
            what: what.into(),
            folder: out.into(),
        };
        let noted = &there.statistics[SOURCE];
        if !noted.is_null() && *noted != source(files)? {
            return Err(other("list of files").into());
        }
        if let Some(given) = given {
            let scene = given.load(id, seed, SceneSettings::default());
            let scene = scene.at(Place::Map(id))?;
            if let Some(what) = identity::contradicted(&there, &scene, given.raster())? {
                return Err(other(what).into());
            }
        }
    }
    let todo = || maps.iter().filter(|(id, _)| !writer.has_map(**id));
    if todo().next().is_some() {
        writer.set_plan(&control.plan(maps.keys().copied().collect(), None))?;
    }
    control.progress.begin(Work {
        units: todo().map(|(_, files)| files.len() as u64).sum(),
        name: "files",
        finished_maps: maps.len() - todo().count(),
        maps: maps.len(),
    });
    for (&id, files) in todo() {
        control.progress.map(id);
        or_kept(
            map(&writer, id, files).at(Place::Map(id)),
            &writer,
            out,
            control,
        )?;
    }
    let ids = writer.map_ids();
    Ok(Imported {
        totals: writer.finish(&split_of_imported(&ids, seed))?.totals,
        left_out: LeftOut::default(),
    })
}

/// Checksum of the names and sizes of the files that a map is made of, which the map keeps. It tells another source unless names and
/// sizes are the same.
pub fn source<T: AsRef<Path>>(files: &[T]) -> Result<Value> {
    let mut list = String::new();
    for path in files.iter().map(AsRef::as_ref) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let bytes = fs::metadata(path).at_file(Place::Reading, path)?.len();
        list.push_str(&format!("{bytes} {name}\n"));
    }
    Ok(sha256_of(list.as_bytes()).into())
}

/// Rows of links whose ends the map's list tells, and whose tracer is unknown.
pub fn without_ends(rows: LinkRows<'_>) -> LinkRows<'_> {
    LinkRows {
        links: None,
        fallback: None,
        ..rows
    }
}

/// Refuses a folder without files to import.
pub fn must_have_maps<T>(
    maps: &BTreeMap<u32, Vec<T>>,
    folder: &Path,
    expected: &'static str,
) -> Result<(), ExchangeError> {
    match maps.is_empty() {
        true => Err(ExchangeError::Nothing {
            folder: folder.into(),
            expected,
        }),
        false => Ok(()),
    }
}
