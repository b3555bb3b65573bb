//! `cargo xtask dataset`: maps in, labelled data set out.

use std::path::PathBuf;

use anyhow::Result;
use aps_data::{Access, Plan, Split};
use aps_label::{LabelConfig, Labeler, Protocol};
use clap::{Subcommand, ValueEnum};

use crate::args::{self, Shard, Store, TraceArgs};
use crate::cautions;
use crate::command_line;
use crate::maps::{IdList, MapSource, SceneSettings, choose};
use crate::plan::DatasetPlan;
use crate::production;
use crate::progress;
use crate::sampling::Receivers;
use crate::say;
use crate::summary::Summary;
use crate::tiles::TileArgs;

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
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
}

/// Data set to make, and its folder: for every command that makes one.
#[derive(Debug, clap::Args)]
pub struct Order {
    /// Folder of RadioMapSeer files 0.json, 1.json, ..., a FILE with a city in GeoJSON, or
    /// synthetic[:N] for N made-up cities.
    #[arg(long, default_value = "synthetic")]
    pub maps: MapSource,
    /// Maps to use, like 0-4,7 [default: by profile].
    #[arg(long)]
    map_ids: Option<IdList>,
    /// Size of the run where nothing else is said.
    #[arg(long, value_enum, default_value_t = Profile::Quick)]
    profile: Profile,
    /// Transmitters a map [default: by profile].
    #[arg(long)]
    tx_per_map: Option<usize>,
    /// Receivers of each transmitter [default: by profile].
    #[arg(long)]
    rx_per_map: Option<usize>,
    /// Choice of the points of receivers.
    #[arg(long, value_enum, default_value_t = Receivers::Reached)]
    receivers: Receivers,
    /// Definition of the label: released (what the published code computes) or paper.
    #[arg(long, default_value = "released")]
    protocol: Protocol,
    /// Data to store: any of aps,pdp,paths.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "aps")]
    store: Vec<Store>,
    /// Seed of terminals, synthetic cities and split.
    #[arg(long, default_value_t = 42)]
    seed: u64,
    /// Folder of the data set; an unfinished one is continued.
    #[arg(long, default_value = "data/dataset")]
    pub out: PathBuf,
    #[command(flatten)]
    scene: SceneSettings,
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
        let order = self.order.read()?;
        progress::use_threads(self.threads)?;
        let ids = order.map_ids()?;
        let plan = order.plan();
        plan.trace.validate()?;
        cautions::tell_carrier(&plan.trace);
        let labeler = Labeler::new(&plan.label)?;
        let access = self.shard.map_or(Access::Whole, |shard| shard.access());
        let out = &order.out;
        let writer = plan.open(out, access)?;
        if ids.iter().any(|&id| !writer.has_map(id)) {
            writer.set_plan(&Plan {
                maps: ids.clone(),
                shards: self.shard.map(|shard| shard.count),
                command: command_line::own_without(&["--out", "--shard", "--threads"]),
            })?;
        }
        let own: Vec<u32> = ids.into_iter().filter(|&id| access.covers(id)).collect();
        let mut todo = own.clone();
        todo.retain(|&id| !writer.has_map(id));
        production::tell_finished(todo.len(), own.len());
        let links = todo.len() as u64 * order.links_per_map();
        let mut repairs = Vec::new();
        let (tally, wall) =
            production::make_maps(&writer, &labeler, out, &todo, links, |run, id| {
                plan.map(run, id, &mut repairs)
            })?;
        if self.shard.is_none() {
            let all = writer.map_ids();
            writer.finish(&Split::of_maps(all, order.seed))?;
        }
        cautions::tell_near(&plan.trace, tally.near_links);
        for line in repairs {
            say!("{line}")?;
        }
        let tally = &tally;
        say!("{}", Summary { tally, wall })?;
        match self.shard {
            None => say!("data set '{}'", out.display())?,
            Some(shard) => say!(
                "shard {shard} in '{0}': {1} maps; when all shards are done: {2} DIR... --out DIR",
                out.display(),
                own.len(),
                command_line::shown(["dataset", "merge"]),
            )?,
        }
        Ok(())
    }
}

impl Order {
    /// The same with its maps read, if they come from a city.
    pub fn read(mut self) -> Result<Self> {
        self.maps = self.maps.cut(self.tiles.settings())?;
        Ok(self)
    }

    /// Settings that decide the data set.
    pub fn plan(&self) -> DatasetPlan {
        let (_, tx_per_map, rx_per_map) = self.sizes();
        let stored = args::stored(&self.store);
        DatasetPlan {
            maps: self.maps.clone(),
            scene: self.scene,
            tx_per_map,
            rx_per_map,
            receivers: self.receivers,
            label: LabelConfig {
                pdp: stored.pdp,
                ..LabelConfig::of(self.protocol)
            },
            stored,
            seed: self.seed,
            trace: self.trace.config(),
        }
    }

    /// Links of each map.
    pub fn links_per_map(&self) -> u64 {
        let (_, tx, rx) = self.sizes();
        tx as u64 * rx as u64
    }

    /// Synthetic maps, transmitters, receivers.
    fn sizes(&self) -> (usize, usize, usize) {
        let (maps, tx, rx) = match self.profile {
            Profile::Smoke => (2, 4, 20),
            Profile::Quick => (10, 20, 100),
            Profile::Full => (51, 100, 500),
        };
        (
            maps,
            self.tx_per_map.unwrap_or(tx),
            self.rx_per_map.unwrap_or(rx),
        )
    }

    /// The maps of the data set, ascending.
    pub fn map_ids(&self) -> Result<Vec<u32>> {
        let (count, ..) = self.sizes();
        let mut available = self.maps.ids(count as u32)?;
        match &self.map_ids {
            Some(chosen) => choose(&available, chosen),
            None => {
                let asked = matches!(self.maps, MapSource::Synthetic { count: Some(_) });
                if !asked && self.profile != Profile::Full {
                    available.truncate(count);
                }
                Ok(available)
            }
        }
    }
}
