//! `cargo xtask dataset`: maps in, labelled data set out.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use aps_data::Split;
use aps_label::Protocol;
use clap::ValueEnum;

use crate::args::TraceArgs;
use crate::interrupt::interrupt_flag;
use crate::maps::{IdList, MapSource, choose};
use crate::plan::{DatasetPlan, Store};
use crate::summary::Summary;
use crate::tiles::TileArgs;

/// Sizes of a run; any of them can be set by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Profile {
    /// 2 maps, 4 x 20 links: does it run?
    Smoke,
    /// 10 maps, 20 x 100 links: a minute or less.
    Quick,
    /// All maps (51 synthetic ones), 100 x 500 links: the size of the paper.
    Full,
}

/// Make a labelled data set from maps.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of RadioMapSeer files 0.json, 1.json, ..., a city in FILE.geojson, or synthetic[:N]
    /// for N made-up cities.
    #[arg(long, default_value = "synthetic")]
    maps: MapSource,
    /// Which of them, like 0-4,7 [default: by profile].
    #[arg(long)]
    map_ids: Option<IdList>,
    /// Size of the run where nothing else is said.
    #[arg(long, value_enum, default_value_t = Profile::Quick)]
    profile: Profile,
    /// Transmitters a map [default: by profile].
    #[arg(long)]
    tx_per_map: Option<usize>,
    /// Receivers a map, shared by its transmitters [default: by profile].
    #[arg(long)]
    rx_per_map: Option<usize>,
    /// Definition of the label: released (what the published code computes) or paper.
    #[arg(long, default_value = "released")]
    protocol: Protocol,
    /// What to store: any of aps,pdp,paths.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "aps")]
    store: Vec<Store>,
    /// Seed of terminals, synthetic cities and split.
    #[arg(long, default_value_t = 42)]
    seed: u64,
    /// Threads [default: all cores]. The result does not depend on it.
    #[arg(long)]
    threads: Option<usize>,
    /// Folder of the data set; an unfinished one is continued.
    #[arg(long, default_value = "data/dataset")]
    out: PathBuf,
    #[command(flatten)]
    trace: TraceArgs,
    #[command(flatten)]
    tiles: TileArgs,
}

impl Args {
    /// Runs the command.
    pub fn run(mut self) -> Result<()> {
        self.maps = self.maps.cut(&self.tiles)?;
        if let Some(threads) = self.threads {
            ensure!(threads > 0, "--threads must be at least 1");
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build_global()?;
        }
        let (maps, tx_per_map, rx_per_map) = self.sizes();
        let ids = self.map_ids(maps)?;
        let plan = DatasetPlan {
            split: Split::of_maps(ids.iter().copied(), self.seed),
            ids,
            tx_per_map,
            rx_per_map,
            protocol: self.protocol,
            store: self.store,
            seed: self.seed,
            trace: self.trace.config(),
            maps: self.maps,
        };
        let made = plan.make(&self.out, &*interrupt_flag()?)?;
        for line in &made.repairs {
            println!("{line}");
        }
        println!(
            "{}",
            Summary {
                tally: &made.tally,
                wall: made.wall
            }
        );
        println!("data set '{}'", self.out.display());
        Ok(())
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

    fn map_ids(&self, count: usize) -> Result<Vec<u32>> {
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
