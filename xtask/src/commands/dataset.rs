//! `cargo xtask dataset`: maps in, labelled data set out.

use std::path::PathBuf;

use anyhow::Result;
use aps_data::Access;
use clap::{Subcommand, ValueEnum};
use map2aps::maps::{MAX_ORIENTATIONS, NamedMaps, choose};
use map2aps::{DatasetPlan, Receivers, SEED, SceneSettings};

use crate::args::{self, IdList, LabelArgs, SceneArgs, Store, TileArgs, TraceArgs, parse_shard};
use crate::cautions;
use crate::command_line;
use crate::progress::{self, Bar};
use crate::summary::Summary;
use crate::{note, say};

mod merge;

/// Sizes of a run; any of them can be set by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Profile {
    /// 2 maps, 4 x 20 links: does it run?
    Smoke,
    /// 10 maps, 20 x 100 links: a minute or less.
    Quick,
    /// Every map (51 synthetic ones), 100 x 500 links: the size of the paper.
    Full,
}

/// Make a labelled data set from maps.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(subcommand)]
    action: Option<Action>,
    #[command(flatten)]
    order: Order,
    /// Threads [default: all cores]. The result does not depend on it.
    #[arg(long)]
    threads: Option<usize>,
    /// Make the maps of one shard only, like 1/4: shards may run at once, in one folder or in one each, and
    /// `dataset merge` joins them.
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    shard: Option<Access>,
}

/// Data set to make, and its folder: for every command that makes one.
#[derive(Debug, clap::Args)]
pub struct Order {
    /// Folder of RadioMapSeer files 0.json, 1.json, ..., a FILE with a city in GeoJSON, or
    /// synthetic[:N] for N made-up cities.
    #[arg(long, default_value = "synthetic")]
    pub maps: NamedMaps,
    /// Maps to use, like 0-4,7 [default: by profile].
    #[arg(long)]
    map_ids: Option<IdList>,
    /// Make the training maps in so many orientations, of 8: quarter turns, then their mirror images, each with terminals of its
    /// own. Copy k of map 7 is map k000007; development and test maps stay as they are.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_ORIENTATIONS)))]
    orientations: u32,
    /// Size of the run where nothing else is said.
    #[arg(long, value_enum, default_value_t = Profile::Quick)]
    profile: Profile,
    /// Transmitters a map [default: by profile].
    #[arg(long)]
    tx_per_map: Option<usize>,
    /// Receivers of each transmitter [default: by profile].
    #[arg(long)]
    rx_per_map: Option<usize>,
    /// Receivers of a transmitter: reached (the first points that it reaches inside the limits, as in published data) or
    /// outdoor (the same points for all transmitters of a map, reached or not).
    #[arg(long, default_value = "reached")]
    receivers: Receivers,
    /// Data to store: any of aps,pdp,paths.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "aps")]
    store: Vec<Store>,
    /// Seed of terminals, synthetic cities and split.
    #[arg(long, default_value_t = SEED)]
    seed: u64,
    /// Folder of the data set; an unfinished one is continued.
    #[arg(long, default_value = "data/dataset")]
    pub out: PathBuf,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    label: LabelArgs,
    #[command(flatten)]
    trace: TraceArgs,
    #[command(flatten)]
    pub tiles: TileArgs,
}

/// Other actions on a data set in the making.
#[derive(Debug, Subcommand)]
enum Action {
    /// Join what shards made into what one run would have made.
    Merge(merge::Args),
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        if let Some(Action::Merge(args)) = self.action {
            return args.run();
        }
        progress::use_threads(self.threads)?;
        let (plan, ids) = self.order.read()?;
        let out = &self.order.out;
        let bar = Bar::default();
        let command = command_line::own_without(&["--out", "--shard", "--threads"]);
        let control = bar.control(&command)?;
        let access = self.shard.unwrap_or_default();
        let made = plan.make_shard(out, &ids, access, &control)?;
        bar.clear();
        cautions::tell_carrier(&plan.trace);
        cautions::tell_near(&plan.trace, made.tally.near_links);
        say!("{}", Summary(&made))?;
        match args::shard(access) {
            None => say!("data set '{}'", out.display())?,
            Some(shard) => say!(
                "shard {shard} in '{0}', maps: {1}; when all shards are done: {2} DIR... --out DIR",
                out.display(),
                plan.with_copies(&ids)?
                    .iter()
                    .filter(|&&id| access.covers(id))
                    .count(),
                command_line::shown(["dataset", "merge"]),
            )?,
        }
        Ok(())
    }
}

impl Order {
    /// Opens the maps; returns the settings that decide the data set, and its maps without their copies, ascending.
    pub fn read(&self) -> Result<(DatasetPlan, Vec<u32>)> {
        let (profile, count, tx_per_map, rx_per_map) = match self.profile {
            Profile::Smoke => ("smoke", 2, 4, 20),
            Profile::Quick => ("quick", 10, 20, 100),
            Profile::Full => ("full", 51, 100, 500),
        };
        let maps = self.tiles.open(&self.maps, count)?;
        let mut ids = maps.ids()?;
        match &self.map_ids {
            Some(chosen) => ids = choose(&ids, &chosen.0).map_err(map2aps::Error::from)?,
            None if matches!(self.maps, NamedMaps::Synthetic { .. }) => {}
            None if self.profile == Profile::Full || ids.len() <= count as usize => {}
            None => {
                note!(
                    "{count} of {} maps (profile {profile}); --profile full or --map-ids for others",
                    ids.len()
                );
                ids.truncate(count as usize);
            }
        }
        let stored = args::stored(&self.store);
        let plan = DatasetPlan {
            maps,
            scene: SceneSettings {
                orientations: self.orientations,
                ..self.scene.settings()
            },
            tx_per_map: self.tx_per_map.unwrap_or(tx_per_map),
            rx_per_map: self.rx_per_map.unwrap_or(rx_per_map),
            receivers: self.receivers,
            label: self.label.config(stored.pdp),
            stored,
            seed: self.seed,
            trace: self.trace.config(),
        };
        Ok((plan, ids))
    }
}
