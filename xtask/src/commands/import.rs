//! `cargo xtask import`: the files of the published data as a data set.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use aps_data::released::LinkName;
use aps_data::{DatasetConfig, DatasetWriter, Plan, Raster, RasterGrid, Split};
use clap::Subcommand;
use indicatif::ProgressBar;

use crate::command_line;
use crate::maps::{self, MapSource, SceneSettings};
use crate::progress;
use crate::say;

mod propbin;
mod released;
mod rows;
mod samples;

/// Links read between two writes.
const LINKS_AT_ONCE: usize = 2048;

/// Make a data set of the published data's files.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    from: From,
}

#[derive(Debug, Subcommand)]
enum From {
    /// Paths in .propbin or .propbin.gz files: a file a transmitter, a folder map_N a map.
    Propbin(propbin::Args),
    /// Labels in map_N/N_adps/aps/aps_*.npy, and PDPs beside them.
    Released(released::Args),
    /// Normalised labels with condition images in samples/aps_*.npz.
    Samples(samples::Args),
}

/// Options that all imports take.
#[derive(Debug, clap::Args)]
struct Target {
    /// Folder of the data set; an unfinished one is continued.
    #[arg(long)]
    out: PathBuf,
    /// Seed of the split.
    #[arg(long, default_value_t = 42)]
    seed: u64,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        match self.from {
            From::Propbin(args) => args.run(),
            From::Released(args) => args.run(),
            From::Samples(args) => args.run(),
        }
    }
}

impl Target {
    /// Makes those of the maps that are not there, and finishes the data set.
    fn make<T>(
        &self,
        config: DatasetConfig,
        maps: &BTreeMap<u32, Vec<T>>,
        mut map: impl FnMut(&DatasetWriter, u32, &[T], &ProgressBar) -> Result<()>,
    ) -> Result<()> {
        let writer = DatasetWriter::open(&self.out, config)
            .with_context(|| format!("data set '{}'", self.out.display()))?;
        let todo = || maps.iter().filter(|(id, _)| !writer.has_map(**id));
        if todo().next().is_some() {
            writer.set_plan(&Plan {
                maps: maps.keys().copied().collect(),
                shards: None,
                command: command_line::own_without(&["--out"]),
            })?;
        }
        let files = todo().map(|(_, files)| files.len() as u64).sum();
        let progress = progress::bar(files, "files");
        for (&id, files) in todo() {
            progress.set_message(format!("map {id}"));
            map(&writer, id, files, &progress).with_context(|| format!("map {id}"))?;
        }
        progress.finish_and_clear();
        let manifest = {
            let ids = writer.map_ids();
            writer.finish(&Split::of_maps(ids, self.seed))?
        };
        let states = manifest.totals.status.iter();
        let states: Vec<String> = states
            .map(|(name, count)| format!("{count} {name}"))
            .collect();
        say!(
            "{} maps, {} links ({}), {} paths in '{}'",
            manifest.totals.maps,
            manifest.totals.links,
            states.join(", "),
            manifest.totals.paths,
            self.out.display()
        )?;
        Ok(())
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
        Self {
            links: names
                .iter()
                .map(|n| [row(&tx, n.tx_m), row(&rx, n.rx_m)])
                .collect(),
            tx_m: metres(&tx),
            rx_m: metres(&rx),
        }
    }
}

/// The files of a folder that are named after links, in the order of the names.
fn named_files(folder: &Path, beginning: &str, end: &str) -> Result<Vec<LinkName>> {
    let mut names = Vec::new();
    for entry in
        fs::read_dir(folder).with_context(|| format!("cannot read '{}'", folder.display()))?
    {
        let name = entry?.file_name();
        names.extend(
            name.to_str()
                .and_then(|name| LinkName::of_file(name, beginning, end)),
        );
    }
    names.sort_unstable();
    Ok(names)
}

fn must_have_maps<T>(maps: &BTreeMap<u32, Vec<T>>, folder: &Path, expected: &str) -> Result<()> {
    ensure!(
        !maps.is_empty(),
        "nothing to import in '{}': expected {expected}",
        folder.display()
    );
    Ok(())
}
