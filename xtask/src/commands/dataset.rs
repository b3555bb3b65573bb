//! `cargo xtask dataset`: maps in, labelled data set out.

use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};
use aps_data::{Axis, DatasetConfig, DatasetWriter, Layout, ProfileLayout, Split};
use aps_label::{LabelConfig, Labeler, Protocol};
use aps_raytrace::{Material, TraceConfig};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use crate::args::TraceArgs;
use crate::interrupt::interrupt_flag;
use crate::maps::{IdList, MapSource, choose};
use crate::produce::Run;
use crate::sampling;
use crate::summary::{Summary, Tally};
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

/// Things a data set can store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Store {
    /// Angle power spectra.
    Aps,
    /// Power delay profiles.
    Pdp,
    /// Propagation paths: labels can be made anew from them.
    Paths,
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
        let (maps, tx, rx) = self.sizes();
        let ids = self.map_ids(maps)?;
        let trace = self.trace.config();
        trace.validate()?;
        let label = LabelConfig {
            pdp: self.store.contains(&Store::Pdp),
            ..LabelConfig::of(self.protocol)
        };
        let labeler = Labeler::new(&label)?;
        let writer = DatasetWriter::open(&self.out, self.config(&trace, &label, tx, rx))
            .with_context(|| format!("data set '{}'", self.out.display()))?;

        let todo: Vec<u32> = ids
            .iter()
            .copied()
            .filter(|&id| !writer.has_map(id))
            .collect();
        if todo.len() < ids.len() {
            eprintln!(
                "{} of {} maps are there already",
                ids.len() - todo.len(),
                ids.len()
            );
        }
        let links = (todo.len() * tx * rx) as u64;
        let progress = progress_bar(links);
        let interrupted = interrupt_flag()?;
        let run = Run {
            writer: &writer,
            trace: &trace,
            labeler: &labeler,
            progress: &progress,
            interrupted: &interrupted,
        };
        let started = Instant::now();
        let mut total = Tally::default();
        let mut repairs = Vec::new();
        for &id in &todo {
            progress.set_message(format!("map {id}"));
            let made = self.one_map(&run, id, tx, rx, &mut repairs);
            if run.interrupted.load(Ordering::Relaxed) {
                progress.abandon();
                let done = writer.map_ids().len();
                bail!(
                    "interrupted; {done} whole maps are kept in '{}', the same command continues",
                    self.out.display()
                );
            }
            total.add(&made?);
        }
        progress.finish_and_clear();
        let wall = started.elapsed();
        let all = writer.map_ids();
        writer.finish(&Split::of_maps(all, self.seed))?;
        for line in repairs {
            println!("{line}");
        }
        println!(
            "{}",
            Summary {
                tally: &total,
                wall
            }
        );
        println!("data set '{}'", self.out.display());
        Ok(())
    }

    fn one_map(
        &self,
        run: &Run<'_>,
        id: u32,
        tx: usize,
        rx: usize,
        repairs: &mut Vec<String>,
    ) -> Result<Tally> {
        let map = self.maps.load(id, self.seed)?;
        if !map.scene.report().is_clean() {
            repairs.push(format!("map {id}: {}", map.scene.report()));
        }
        let terminals = sampling::draw(&map.scene, self.seed, id, tx, rx)?;
        run.map(id, &map, &terminals)
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

    /// Everything that decides the bytes, as the manifest keeps it.
    fn config(
        &self,
        trace: &TraceConfig,
        label: &LabelConfig,
        tx: usize,
        rx: usize,
    ) -> DatasetConfig {
        let stores = |what| self.store.contains(&what);
        let angles = match self.protocol {
            Protocol::Released => Axis::ANGLE_RELEASED_DEG,
            _ => Axis::ANGLE_PAPER_DEG,
        };
        let delays = Axis {
            start: 0.0,
            stop: label.delay_axis.last_s * 1e9,
            count: label.delay_axis.points,
            endpoint: true,
        };
        DatasetConfig {
            seed: self.seed,
            layout: Layout {
                aps: stores(Store::Aps).then(|| ProfileLayout::over(angles)),
                pdp: stores(Store::Pdp).then(|| ProfileLayout::over(delays)),
                paths: stores(Store::Paths),
                raster: self.maps.raster(),
            },
            configuration: json!({
                "maps": self.maps.describe(),
                "sampling": { "tx_per_map": tx, "rx_per_map": rx, "grid_m": 1.0 },
                "trace": trace_json(trace),
                "label": label,
            }),
        }
    }
}

fn trace_json(c: &TraceConfig) -> serde_json::Value {
    let material = match c.material {
        Material::Concrete => json!("concrete"),
        Material::PerfectConductor => json!("pec"),
        Material::Dielectric {
            relative_permittivity,
            conductivity_s_per_m,
        } => json!([relative_permittivity, conductivity_s_per_m]),
    };
    json!({
        "frequency_hz": c.frequency_hz,
        "material": material,
        "max_reflections": c.max_reflections,
        "max_diffractions": c.max_diffractions,
        "max_interactions": c.max_interactions,
        "dynamic_range_db": c.dynamic_range_db,
        "accuracy_db": c.accuracy_db,
        "max_fallback_diffractions": c.max_fallback_diffractions,
    })
}

fn progress_bar(links: u64) -> ProgressBar {
    let style = ProgressStyle::with_template(
        "{msg:8} [{bar:40}] {human_pos}/{human_len} links, {per_sec}, {eta} left",
    )
    .expect("the template is well formed")
    .progress_chars("=> ");
    ProgressBar::new(links).with_style(style)
}
