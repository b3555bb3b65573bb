//! Everything that decides a data set, and how it is made.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use aps_data::{Axis, DatasetConfig, DatasetWriter, Layout, ProfileLayout, Split};
use aps_label::{LabelConfig, Labeler, Protocol};
use aps_raytrace::{Material, TraceConfig};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use crate::maps::MapSource;
use crate::picture::Outlines;
use crate::produce::Run;
use crate::sampling;
use crate::summary::Tally;

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

/// A data set to be made: the same plan gives the same bytes.
#[derive(Debug, Clone)]
pub struct DatasetPlan {
    /// Where maps come from.
    pub maps: MapSource,
    /// Which of them, ascending.
    pub ids: Vec<u32>,
    /// Transmitters a map.
    pub tx_per_map: usize,
    /// Receivers a map, shared by its transmitters.
    pub rx_per_map: usize,
    /// Definition of the label.
    pub protocol: Protocol,
    /// What to store.
    pub store: Vec<Store>,
    /// Seed of terminals and synthetic cities. Terminals of a map depend on neither limits nor other maps.
    pub seed: u64,
    /// What to trace.
    pub trace: TraceConfig,
    /// Which maps train, develop, test.
    pub split: Split,
}

/// What was made now, and in which time.
#[derive(Debug, Clone, Default)]
pub struct Production {
    pub(crate) tally: Tally,
    /// Time from the first map to the last.
    pub wall: Duration,
    /// Links of each map made now, and the time from reading the map to its written labels, on all threads.
    pub maps: Vec<(u64, Duration)>,
    /// What was repaired in maps, one line a map.
    pub repairs: Vec<String>,
}

impl DatasetPlan {
    /// Makes the maps that `out` does not hold yet.
    ///
    /// # Errors
    /// Settings out of range, a folder with a data set of other settings, maps that cannot be read, and the raised flag
    /// `interrupted`: whole maps are then kept, and the same plan continues.
    pub fn make(&self, out: &Path, interrupted: &AtomicBool) -> Result<Production> {
        self.trace.validate()?;
        let labeler = Labeler::new(&self.label())?;
        let writer = DatasetWriter::open(out, self.config())
            .with_context(|| format!("data set '{}'", out.display()))?;
        let is_missing = |id: &u32| !writer.has_map(*id);
        let todo: Vec<u32> = self.ids.iter().copied().filter(is_missing).collect();
        let (there, all) = (self.ids.len() - todo.len(), self.ids.len());
        if there > 0 {
            eprintln!("{there} of {all} maps are there already");
        }
        let progress = progress_bar((todo.len() * self.tx_per_map * self.rx_per_map) as u64);
        let run = Run {
            writer: &writer,
            trace: &self.trace,
            labeler: &labeler,
            progress: &progress,
            interrupted,
        };
        let started = Instant::now();
        let mut made = Production::default();
        for &id in &todo {
            progress.set_message(format!("map {id}"));
            let one = self.one_map(&run, id, &mut made);
            if interrupted.load(Ordering::Relaxed) {
                progress.abandon();
                bail!(
                    "interrupted; {} whole maps are kept in '{}', the same command continues",
                    writer.map_ids().len(),
                    out.display()
                );
            }
            one?;
        }
        progress.finish_and_clear();
        made.wall = started.elapsed();
        writer.finish(&self.split)?;
        Ok(made)
    }

    fn one_map(&self, run: &Run<'_>, id: u32, made: &mut Production) -> Result<()> {
        let started = Instant::now();
        let map = self.maps.load(id, self.seed)?;
        if !map.scene.report().is_clean() {
            made.repairs
                .push(format!("map {id}: {}", map.scene.report()));
        }
        let terminals =
            sampling::draw(&map.scene, self.seed, id, self.tx_per_map, self.rx_per_map)?;
        let tally = run.map(id, &map, &terminals)?;
        made.maps.push((tally.links, started.elapsed()));
        made.tally.add(&tally);
        Ok(())
    }

    /// Rings of a map's buildings \[m\]; what lies in an odd number of them is indoors.
    pub fn outlines(&self, id: u32) -> Result<Vec<Vec<[f64; 2]>>> {
        let outlines = Outlines::of_scene(&self.maps.load(id, self.seed)?.scene);
        let ring = |ring: &Vec<_>| {
            ring.iter()
                .map(aps_raytrace::glam::DVec2::to_array)
                .collect()
        };
        Ok(outlines.rings.iter().map(ring).collect())
    }

    /// How labels are made.
    pub fn label(&self) -> LabelConfig {
        LabelConfig {
            pdp: self.store.contains(&Store::Pdp),
            ..LabelConfig::of(self.protocol)
        }
    }

    /// Everything that decides the bytes, as the manifest keeps it.
    pub fn config(&self) -> DatasetConfig {
        let stores = |what| self.store.contains(&what);
        let angles = match self.protocol {
            Protocol::Released => Axis::ANGLE_RELEASED_DEG,
            _ => Axis::ANGLE_PAPER_DEG,
        };
        let label = self.label();
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
                "sampling": {
                    "tx_per_map": self.tx_per_map,
                    "rx_per_map": self.rx_per_map,
                    "grid_m": 1.0,
                },
                "trace": trace_json(&self.trace),
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
