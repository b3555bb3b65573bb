//! `cargo xtask import`: the files of the published data as a data set.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Subcommand;
use map2aps::maps::NamedMaps;
use map2aps::{ImportPropbin, ImportReleased, ImportSamples, Imported, MapSource, SEED, counted};

use crate::args::{self, LabelArgs, Store, TileArgs};
use crate::command_line;
use crate::progress::Bar;
use crate::say;

/// Make a data set of the published data's files.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    from: From,
}

#[derive(Debug, Subcommand)]
enum From {
    /// Paths in .propbin or .propbin.gz files: a file a transmitter, a folder map_N a map.
    Propbin(PropbinArgs),
    /// Labels in map_N/N_adps/aps/aps_*.npy, and PDPs beside them.
    Released(ReleasedArgs),
    /// Normalised labels with condition images in samples/aps_*.npz.
    Samples(SamplesArgs),
}

/// Options that all imports take.
#[derive(Debug, clap::Args)]
struct Target {
    /// Folder of the data set; an unfinished one is continued.
    #[arg(long)]
    out: PathBuf,
    /// Seed of the split, of receivers that are drawn, and of synthetic maps.
    #[arg(long, default_value_t = SEED)]
    seed: u64,
}

/// Options of imports that take buildings from elsewhere.
#[derive(Debug, clap::Args)]
struct Buildings {
    /// Buildings of the maps: a folder of 0.json, 1.json, ... [default: none, their images stay empty].
    #[arg(long)]
    maps: Option<NamedMaps>,
    #[command(flatten)]
    tiles: TileArgs,
}

impl Buildings {
    fn open(&self) -> Result<Option<MapSource>> {
        match &self.maps {
            Some(maps) => Ok(Some(self.tiles.open(maps, 0)?)),
            None => self.tiles.must_be_default().map(|()| None),
        }
    }
}

/// Import paths in .propbin or .propbin.gz files: a file a transmitter, a folder map_N a map.
#[derive(Debug, clap::Args)]
struct PropbinArgs {
    /// A file, or a folder to be searched with all folders in it.
    source: PathBuf,
    /// Number of the map for files that are in no folder map_N.
    #[arg(long, default_value_t = 0)]
    map_id: u32,
    /// Draw so many of a map's receivers [default: all].
    #[arg(long)]
    rx_per_map: Option<usize>,
    #[command(flatten)]
    label: LabelArgs,
    /// Data to store: any of aps,pdp,paths.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "aps,paths")]
    store: Vec<Store>,
    #[command(flatten)]
    target: Target,
    #[command(flatten)]
    buildings: Buildings,
}

/// Import labels in map_N/N_adps/aps/aps_*.npy, and PDPs beside them.
#[derive(Debug, clap::Args)]
struct ReleasedArgs {
    /// Folder that holds map_0, map_1, ...
    folder: PathBuf,
    #[command(flatten)]
    target: Target,
    #[command(flatten)]
    buildings: Buildings,
}

/// Import normalised labels with condition images in samples/aps_*.npz.
#[derive(Debug, clap::Args)]
struct SamplesArgs {
    /// Folder that holds samples/.
    folder: PathBuf,
    #[command(flatten)]
    target: Target,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let bar = Bar::default();
        let command = command_line::own_without(&["--out"]);
        let control = bar.control(&command)?;
        let (out, imported) = match self.from {
            From::Propbin(args) => {
                let stored = args::stored(&args.store);
                let import = ImportPropbin {
                    maps: args.buildings.open()?,
                    label: args.label.config(stored.pdp),
                    source: args.source,
                    map_id: args.map_id,
                    rx_per_map: args.rx_per_map,
                    stored,
                    seed: args.target.seed,
                };
                let imported = import.run(&args.target.out, &control)?;
                (args.target.out, imported)
            }
            From::Released(args) => {
                let import = ImportReleased {
                    maps: args.buildings.open()?,
                    folder: args.folder,
                    seed: args.target.seed,
                };
                let imported = import.run(&args.target.out, &control)?;
                (args.target.out, imported)
            }
            From::Samples(args) => {
                let import = ImportSamples {
                    folder: args.folder,
                    seed: args.target.seed,
                };
                let imported = import.run(&args.target.out, &control)?;
                (args.target.out, imported)
            }
        };
        bar.clear();
        print(&out, &imported)
    }
}

fn print(out: &Path, imported: &Imported) -> Result<()> {
    let (totals, left_out) = (&imported.totals, &imported.left_out);
    let states = totals.status.iter();
    let states: Vec<String> = states.map(|(name, n)| format!("{n} {name}")).collect();
    say!(
        "{}, {} links ({}), {} paths in '{}'",
        counted(totals.maps, "map", "maps"),
        totals.links,
        states.join(", "),
        totals.paths,
        out.display()
    )?;
    let (impossible, repeated) = (left_out.impossible, left_out.repeated_receivers);
    for (count, what) in [
        (
            left_out.not_finite,
            "paths with a number that is not finite",
        ),
        (impossible, "paths with an impossible loss or delay"),
        (repeated, "receivers at the place of an earlier one"),
    ] {
        if count > 0 {
            say!("left out: {count} {what}")?;
        }
    }
    Ok(())
}
