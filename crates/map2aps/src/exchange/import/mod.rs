//! The files of the published data as a data set.

mod propbin;
mod released;
mod samples;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use aps_data::released::LinkName;
use aps_data::{
    DatasetConfig, DatasetWriter, LinkRows, Links, MapInput, Raster, RasterGrid, Split, Totals,
};
use rayon::prelude::*;

use super::ExchangeError;
use crate::control::{Control, Work};
use crate::dataset::Rows;
use crate::error::{At, Place, Result};
use crate::maps::{self, MapSource, SceneSettings};

pub use propbin::{ImportPropbin, LeftOut};
pub use released::ImportReleased;
pub use samples::ImportSamples;

/// Links read between two writes.
const LINKS_AT_ONCE: usize = 2048;

/// Result of an import.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Imported {
    /// Sums over the data set.
    pub totals: Totals,
    /// Entries that are no links or paths.
    pub left_out: LeftOut,
}

/// Makes those of the maps that are not there, and finishes the data set.
fn make<T>(
    out: &Path,
    config: DatasetConfig,
    maps: &BTreeMap<u32, Vec<T>>,
    control: &Control<'_>,
    mut map: impl FnMut(&DatasetWriter, u32, &[T]) -> Result<()>,
) -> Result<Imported> {
    let seed = config.seed;
    let writer = DatasetWriter::open(out, config).at_file(Place::Dataset, out)?;
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
        map(&writer, id, files).at(Place::Map(id))?;
    }
    let ids = writer.map_ids();
    Ok(Imported {
        totals: writer.finish(&Split::of_maps(ids, seed))?.totals,
        left_out: LeftOut::default(),
    })
}

/// Writes a map of links that are named after their ends, a file each, which `link` reads.
fn write_named(
    writer: &DatasetWriter,
    id: u32,
    names: &[LinkName],
    buildings: &Raster,
    control: &Control<'_>,
    link: impl Fn(&LinkName) -> Result<Rows> + Send + Sync,
) -> Result<()> {
    let ends = Ends::of(names);
    let layout = writer.config().layout;
    let input = MapInput {
        buildings,
        tx_m: &ends.tx_m,
        rx_m: &ends.rx_m,
        links: Links::List(&ends.links),
    };
    let mut map = writer.begin_map(id, &input)?;
    for names in names.chunks(LINKS_AT_ONCE) {
        control.check()?;
        let links: Vec<Result<Rows>> = names.par_iter().map(&link).collect();
        let mut rows = Rows::default();
        for link in links {
            rows.append(link?);
        }
        map.push(&without_ends(rows.link_rows(&layout)))?;
        control.progress.advance(names.len() as u64);
    }
    map.finish()?;
    Ok(())
}

/// Rows of links whose ends the map's list tells, and whose tracer is unknown.
fn without_ends(rows: LinkRows<'_>) -> LinkRows<'_> {
    LinkRows {
        links: None,
        fallback: None,
        ..rows
    }
}

/// The image of a map's buildings: drawn from its footprints, or empty where none are given.
fn buildings(maps: Option<&MapSource>, id: u32) -> Result<Raster> {
    match maps {
        Some(maps) => {
            let scene = maps.load(id, 0, SceneSettings::default())?;
            maps::raster(&scene, maps.raster())
        }
        None => Ok(Raster::empty(RasterGrid::default())?),
    }
}

/// Positions of the ends of some links, each once and in order, and the links as rows of these.
struct Ends {
    tx_m: Vec<[f64; 2]>,
    rx_m: Vec<[f64; 2]>,
    links: Vec<[u32; 2]>,
}

impl Ends {
    /// Collects the ends of the links with these sorted names.
    fn of(names: &[LinkName]) -> Self {
        let unique = |place: fn(&LinkName) -> [i32; 2]| {
            let mut places: Vec<[i32; 2]> = names.iter().map(place).collect();
            places.sort_unstable();
            places.dedup();
            places
        };
        let (tx, rx) = (unique(|n| n.tx_m), unique(|n| n.rx_m));
        let row = |places: &[[i32; 2]], place| {
            places.binary_search(&place).expect("it was collected") as u32
        };
        let metres = |places: &[[i32; 2]]| places.iter().map(|p| p.map(f64::from)).collect();
        let link = |n: &LinkName| [row(&tx, n.tx_m), row(&rx, n.rx_m)];
        Self {
            links: names.iter().map(link).collect(),
            tx_m: metres(&tx),
            rx_m: metres(&rx),
        }
    }
}

/// The files of a folder with such a beginning and end, which are named after links, in the order of the names.
///
/// # Errors
/// [`ExchangeError::Unnamed`] for one whose name is no link's: it would be left out without a word.
fn named_files(folder: &Path, beginning: &str, end: &str) -> Result<Vec<LinkName>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).at_file(Place::Reading, folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let Some(name) = name.to_str() else { continue };
        if !(name.starts_with(beginning) && name.ends_with(end)) {
            continue;
        }
        let link = LinkName::of_file(name, beginning, end);
        names.push(link.ok_or_else(|| ExchangeError::Unnamed(entry.path()))?);
    }
    names.sort_unstable();
    Ok(names)
}

fn must_have_maps<T>(
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
