//! A traced data set to be made: everything that decides it, in one place for every command that makes one.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use aps_data::{Access, Dataset, DatasetConfig, DatasetWriter, Layout, Split, Stored};
use aps_label::{LabelConfig, Labeler};
use aps_raytrace::TraceConfig;
use aps_raytrace::glam::DVec2;
use aps_report::picture::Outlines;

use crate::maps::{MapSource, SceneSettings};
use crate::produce::Choice;
use crate::produce::Run;
use crate::production;
use crate::sampling::{self, Receivers, Sampling, Terminals};
use crate::settings;
use crate::summary::Tally;

/// Settings that a traced data set is made from: the same plan gives the same bytes.
#[derive(Debug, Clone)]
pub struct DatasetPlan {
    /// Source of the maps.
    pub maps: MapSource,
    /// Settings for making scenes from the maps.
    pub scene: SceneSettings,
    /// Transmitters a map.
    pub tx_per_map: usize,
    /// Receivers of each transmitter.
    pub rx_per_map: usize,
    /// Choice of the points of receivers.
    pub receivers: Receivers,
    /// Settings of the labels.
    pub label: LabelConfig,
    /// Kinds of data to store.
    pub stored: Stored,
    /// Seed of terminals and synthetic cities. The terminals of a map depend neither on limits nor on other maps.
    pub seed: u64,
    /// Settings of the trace.
    pub trace: TraceConfig,
}

/// Links of a map, and the time from reading the map to its written labels, on all threads.
pub type MapTime = (u64, Duration);

impl DatasetPlan {
    /// Makes the maps of `split` that `out` does not hold yet; returns how long each of them took.
    ///
    /// # Errors
    /// Settings out of range, a folder with a data set of other settings, maps that cannot be read or hold too few
    /// outdoor points, and Ctrl-C: whole maps are then kept, and the same plan continues.
    pub fn make(&self, out: &Path, split: &Split) -> Result<Vec<MapTime>> {
        self.make_by(out, split, |run, id, repairs| self.map(run, id, repairs))
    }

    /// Makes the links of another data set of the same maps with the limits of this plan; otherwise as
    /// [`DatasetPlan::make`].
    ///
    /// # Errors
    /// As [`DatasetPlan::make`], and for a data set that lacks one of the maps.
    pub fn make_like(&self, source: &Dataset, out: &Path, split: &Split) -> Result<Vec<MapTime>> {
        self.make_by(out, split, |run, id, _| {
            let data = source.map(id)?;
            let scene = self.maps.load(id, self.seed, self.scene)?;
            let mut lists = vec![Vec::new(); data.tx_m.len()];
            for [tx, rx] in data.links {
                lists[tx as usize].push(rx);
            }
            let points = |m: &[[f64; 2]]| m.iter().copied().map(DVec2::from).collect();
            let terminals = Terminals {
                tx: points(&data.tx_m),
                rx: points(&data.rx_m),
            };
            run.map(id, &scene, &terminals, Choice::Listed(&lists), &self.trace)
        })
    }

    fn make_by(
        &self,
        out: &Path,
        split: &Split,
        make: impl Fn(&Run<'_>, u32, &mut Vec<String>) -> Result<Tally>,
    ) -> Result<Vec<MapTime>> {
        self.trace.validate()?;
        let labeler = Labeler::new(&self.label)?;
        let writer = self.open(out, Access::Whole)?;
        let mut todo = [&split.train[..], &split.develop, &split.test].concat();
        todo.sort_unstable();
        let all = todo.len();
        todo.retain(|&id| !writer.has_map(id));
        production::tell_finished(todo.len(), all);
        let links = (todo.len() * self.tx_per_map * self.rx_per_map) as u64;
        let (mut times, mut repairs) = (Vec::new(), Vec::new());
        production::make_maps(&writer, &labeler, out, &todo, links, |run, id| {
            let started = Instant::now();
            let tally = make(run, id, &mut repairs)?;
            times.push((tally.links, started.elapsed()));
            Ok(tally)
        })?;
        writer.finish(split)?;
        Ok(times)
    }

    /// Makes one map; appends a line to `repairs` if its buildings were repaired.
    pub(crate) fn map(&self, run: &Run<'_>, id: u32, repairs: &mut Vec<String>) -> Result<Tally> {
        let scene = self.maps.load(id, self.seed, self.scene)?;
        if !scene.report().is_clean() {
            repairs.push(format!("map {id}: {}", scene.report()));
        }
        let sampling = self.sampling();
        let choice = match self.receivers {
            Receivers::Reached => Choice::FirstReached(self.rx_per_map),
            Receivers::Outdoor => Choice::All,
        };
        let terminals = sampling::draw(&scene, self.seed, id, self.tx_per_map, sampling.pool())?;
        run.map(id, &scene, &terminals, choice, &self.trace)
    }

    fn sampling(&self) -> Sampling {
        Sampling {
            tx_per_map: self.tx_per_map,
            rx_per_map: self.rx_per_map,
            grid_m: 1.0,
            receivers: self.receivers,
        }
    }

    /// Rings of a map's buildings \[m\]; a point inside an odd number of them is indoors.
    ///
    /// # Errors
    /// A map that cannot be read.
    pub fn outlines(&self, id: u32) -> Result<Vec<Vec<[f64; 2]>>> {
        let outlines = Outlines::of_scene(&self.maps.load(id, self.seed, self.scene)?);
        let ring = |ring: &Vec<DVec2>| ring.iter().map(DVec2::to_array).collect();
        Ok(outlines.rings.iter().map(ring).collect())
    }

    /// Opens the folder of the data set for writing.
    ///
    /// # Errors
    /// Any of [`DatasetWriter::open_with`].
    pub(crate) fn open(&self, out: &Path, access: Access) -> Result<DatasetWriter> {
        DatasetWriter::open_with(out, self.config(), access)
            .with_context(|| format!("data set '{}'", out.display()))
    }

    /// Everything that decides the bytes, as the manifest keeps it.
    pub fn config(&self) -> DatasetConfig {
        let sampling = self.sampling();
        let (maps, trace, label) = (self.maps.describe(), &self.trace, &self.label);
        DatasetConfig {
            seed: self.seed,
            layout: Layout::of_labels(label, self.maps.raster(), self.stored),
            configuration: settings::of_traced(maps, self.scene, sampling, trace, label),
        }
    }
}
