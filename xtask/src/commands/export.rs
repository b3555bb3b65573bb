//! `cargo xtask export`: a data set as the files of the published data, or as tables.

use std::path::PathBuf;

use anyhow::Result;
use aps_data::{Dataset, Part};
use clap::ValueEnum;
use map2aps::{Export, ExportLayout};

use crate::args::{IdList, parts};
use crate::progress::{self, Bar};
use crate::say;

/// Forms of export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Layout {
    /// map_N/N_adps/{aps,pdp}/*.npy: labels with the places of their maxima, half precision.
    Released,
    /// samples/*.npz: normalised labels with their condition images, as models train on them.
    Samples,
    /// data/PART/map_N.parquet: a row a link, with a card and a description for hubs of data sets.
    #[cfg(feature = "parquet")]
    Parquet,
}

/// Write a data set as the files of the published data, one or two a link, or as tables.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of the data set.
    data: PathBuf,
    /// Form of the files.
    #[arg(long, value_enum)]
    layout: Layout,
    /// Folder to write to; files that are there are kept, so that the same command continues.
    #[arg(long)]
    out: PathBuf,
    /// Only the maps of one part of the split.
    #[arg(long, value_parser = parts())]
    part: Option<Part>,
    /// Only these maps, like 0-4,7.
    #[arg(long)]
    map_ids: Option<IdList>,
    /// At most so many links in all.
    #[arg(long)]
    limit: Option<usize>,
    /// Export labels of another protocol than the released one as they are.
    #[arg(long)]
    any_protocol: bool,
    /// Write 0 for the places of maxima where neither they nor the paths are stored.
    #[arg(long)]
    zero_places: bool,
    /// Threads [default: all cores]. The result does not depend on it.
    #[arg(long)]
    threads: Option<usize>,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        progress::use_threads(self.threads)?;
        let export = Export {
            part: self.part,
            maps: self.map_ids.map(|ids| ids.0),
            limit: self.limit,
            any_protocol: self.any_protocol,
            zero_places: self.zero_places,
            ..Export::new(match self.layout {
                Layout::Released => ExportLayout::Released,
                Layout::Samples => ExportLayout::Samples,
                #[cfg(feature = "parquet")]
                Layout::Parquet => ExportLayout::Parquet,
            })
        };
        let bar = Bar::default();
        let control = bar.control(&[])?;
        let exported = export.run(&Dataset::open(&self.data)?, &self.out, &control)?;
        bar.clear();
        say!(
            "{} links in '{}', {:.1} MB written",
            exported.links,
            self.out.display(),
            exported.bytes as f64 / 1e6
        )
    }
}
