//! Plan of a traced data set: everything that decides its bytes.

use std::path::Path;

use aps_data::{Access, DatasetConfig, Layout, Split, Stored, sha256_of};
use aps_label::{LabelConfig, Labeler};
use aps_raytrace::TraceConfig;
use aps_raytrace::scene::RepairReport;
use rayon::prelude::*;

use crate::control::Control;
use crate::dataset::{Choice, DatasetBuilder, Made, Run};
use crate::error::Result;
use crate::limits::Limits;
use crate::maps::{self, MapError, MapSource, SceneSettings};
use crate::sampling::{self, GRID_M, Receivers, SEED, Sampling};
use crate::settings;
use crate::tally::Tally;

/// Settings that a traced data set is made from: the same plan gives the same bytes, for any number of threads.
///
/// The default is a small data set of synthetic cities with the angle power spectra of protocol `paper`, of paths within the default
/// [`Limits`]: 20 transmitters a map with 100 receivers each.
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
    /// Settings of the labels; [`LabelConfig::pdp`] is taken from `stored`.
    pub label: LabelConfig,
    /// Kinds of data to store.
    pub stored: Stored,
    /// Seed of terminals, synthetic cities and split. The terminals of a map depend neither on limits nor on other maps.
    pub seed: u64,
    /// Settings of the trace.
    pub trace: TraceConfig,
}

impl Default for DatasetPlan {
    fn default() -> Self {
        Self {
            maps: MapSource::Synthetic { count: 10 },
            scene: SceneSettings::default(),
            tx_per_map: 20,
            rx_per_map: 100,
            receivers: Receivers::default(),
            label: LabelConfig::default(),
            stored: Stored::default(),
            seed: SEED,
            trace: Limits::default().config(),
        }
    }
}

impl DatasetPlan {
    /// Makes a data set of the given maps, each once, in the folder `out`, split by the plan's seed, and of the copies of its
    /// training maps ([`SceneSettings::orientations`]). Maps that the folder holds already are kept: the same call continues
    /// what was interrupted.
    ///
    /// # Errors
    /// Settings out of range, a folder with a data set of other settings, maps that cannot be read or hold too few
    /// outdoor points, a disk that fails, and cancellation: whole maps are then kept.
    pub fn make(&self, out: &Path, maps: &[u32], control: &Control<'_>) -> Result<Made> {
        self.make_shard(out, maps, Access::Whole, control)
    }

    /// Makes those of the given maps that a shard may write. Shards may work at once, in one folder or in one each;
    /// [`merge`](crate::merge) joins them.
    ///
    /// # Errors
    /// As [`DatasetPlan::make`].
    pub fn make_shard(
        &self,
        out: &Path,
        maps: &[u32],
        access: Access,
        control: &Control<'_>,
    ) -> Result<Made> {
        let builder = self.builder(out, &self.with_copies(maps)?, access)?;
        // Before the work: it is refused where more maps take a copy's map out of the training.
        let split = maps::split(&builder.all(), self.seed, self.scene.orientations)?;
        let made = self.make_maps(&builder, control)?;
        if access == Access::Whole {
            builder.writer.finish(&split)?;
        }
        Ok(made)
    }

    /// Makes the maps of a given split of upright maps, and the copies of its training maps.
    ///
    /// # Errors
    /// As [`DatasetPlan::make`], and [`MapError::Twice`].
    pub fn make_split(&self, out: &Path, split: &Split, control: &Control<'_>) -> Result<Made> {
        let split = &maps::with_copies(split.clone(), self.scene.orientations)?;
        let maps = split.all_maps();
        if let Some(twice) = maps.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(MapError::Twice(twice[0]).into());
        }
        let builder = self.builder(out, &maps, Access::Whole)?;
        let made = self.make_maps(&builder, control)?;
        builder.writer.finish(split)?;
        Ok(made)
    }

    /// The ids of the given maps and of the copies that are made of them, ascending.
    ///
    /// # Errors
    /// A number of orientations that a square does not have, and ids without room for copies.
    pub fn with_copies(&self, maps: &[u32]) -> Result<Vec<u32>> {
        let split = Split::of_maps(maps.iter().copied(), self.seed);
        Ok(maps::with_copies(split, self.scene.orientations)?.all_maps())
    }

    /// Returns the given maps and copies that the folder `out` lacks, and refuses settings that would make none of them. Creates
    /// the folder if it is not there.
    ///
    /// # Errors
    /// Settings out of range, and a folder with a data set of other settings.
    pub fn missing(&self, out: &Path, maps: &[u32]) -> Result<Vec<u32>> {
        let builder = self.builder(out, &self.with_copies(maps)?, Access::Whole)?;
        Ok(builder.todo)
    }

    /// Settings of the data set, as its manifest keeps them.
    pub fn config(&self) -> DatasetConfig {
        let sampling = self.sampling();
        let (maps, trace, label) = (self.maps.describe(), &self.trace, &self.label());
        DatasetConfig {
            seed: self.seed,
            layout: Layout::of_labels(label, self.maps.raster(), self.stored),
            configuration: settings::of_traced(maps, self.scene, sampling, trace, label),
        }
    }

    /// Settings of the labels that are made.
    fn label(&self) -> LabelConfig {
        LabelConfig {
            pdp: self.stored.pdp,
            ..self.label.clone()
        }
    }

    fn sampling(&self) -> Sampling {
        Sampling {
            tx_per_map: self.tx_per_map,
            rx_per_map: self.rx_per_map,
            grid_m: GRID_M,
            receivers: self.receivers,
        }
    }

    fn builder(&self, out: &Path, maps: &[u32], access: Access) -> Result<DatasetBuilder> {
        self.trace.validate()?;
        let (tx, rx) = (self.tx_per_map, self.rx_per_map);
        if tx == 0 || rx == 0 {
            return Err(MapError::NoLinks { tx, rx }.into());
        }
        let labeler = Labeler::new(&self.label())?;
        DatasetBuilder::open(out, self.config(), labeler, maps, access)
    }

    fn make_maps(&self, builder: &DatasetBuilder, control: &Control<'_>) -> Result<Made> {
        for there in builder.there() {
            control.check()?;
            // One that cannot be read any more cannot be compared.
            if let Ok(scene) = self.maps.load(there.id, self.seed, self.scene) {
                builder.must_be_of(&there, &scene, self.maps.raster())?;
            }
        }
        let of_map = self.tx_per_map.saturating_mul(self.rx_per_map);
        let links = builder.todo.len().saturating_mul(of_map) as u64;
        let mut repairs = Vec::new();
        let mut made = builder.run(links, control, |run, id| self.map(run, id, &mut repairs))?;
        made.repairs = repairs;
        Ok(made)
    }

    /// Makes one map; appends what was repaired of its buildings, if anything was.
    fn map(&self, run: &Run<'_>, id: u32, repairs: &mut Vec<(u32, RepairReport)>) -> Result<Tally> {
        let scene = self.maps.load(id, self.seed, self.scene)?;
        if !scene.report().is_clean() {
            repairs.push((id, scene.report().clone()));
        }
        let choice = match self.receivers {
            Receivers::Reached => Choice::FirstReached(self.rx_per_map),
            Receivers::Outdoor => Choice::All,
        };
        let pool = self.sampling().pool();
        let terminals = sampling::draw(&scene, self.seed, id, self.tx_per_map, pool)?;
        run.map(id, &scene, &terminals, choice, &self.trace)
    }

    /// Computes a checksum of the buildings of some maps, in the order given.
    ///
    /// # Errors
    /// A map that cannot be read.
    pub fn buildings_sha256(&self, maps: &[u32]) -> Result<String> {
        let of_map = |&id: &u32| {
            let scene = self.maps.load(id, self.seed, self.scene)?;
            Ok(format!(
                "{id} {}\n",
                maps::identity::outlines_sha256(&scene)
            ))
        };
        let all: Result<Vec<String>> = maps.par_iter().map(of_map).collect();
        Ok(sha256_of(all?.concat().as_bytes()))
    }

    /// Rings of a map's buildings \[m\]; a point inside an odd number of them is indoors.
    ///
    /// # Errors
    /// A map that cannot be read.
    pub fn outlines(&self, id: u32) -> Result<Vec<Vec<[f64; 2]>>> {
        let scene = self.maps.load(id, self.seed, self.scene)?;
        Ok(maps::outlines(&scene))
    }
}

#[cfg(test)]
mod tests {
    use aps_raytrace::scene::CityConfig;

    use super::*;

    /// A folder of maps that are those of synthetic cities from this seed on.
    fn folder_of_maps(seed: u64) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for id in 0..2 {
            let config = CityConfig {
                seed: seed + id,
                ..CityConfig::default()
            };
            let outlines = config.footprints().unwrap().into_iter().map(|footprint| {
                let ring = footprint.outer.iter().map(|p| p.to_array());
                ring.collect::<Vec<_>>()
            });
            let text = serde_json::to_string(&outlines.collect::<Vec<_>>()).unwrap();
            std::fs::write(folder.path().join(format!("{id}.json")), text).unwrap();
        }
        folder
    }

    #[test]
    fn a_data_set_is_not_continued_with_other_maps_of_the_same_settings() {
        let [own, other] = [0, 7].map(folder_of_maps);
        let out = tempfile::tempdir().unwrap();
        let make = |maps: &tempfile::TempDir, index| {
            let plan = DatasetPlan {
                maps: MapSource::Folder(maps.path().into()),
                tx_per_map: 1,
                rx_per_map: 3,
                ..DatasetPlan::default()
            };
            let shard = Access::Shard { index, count: 2 };
            plan.make_shard(out.path(), &[0, 1], shard, &Control::default())
        };
        make(&own, 0).unwrap();
        let told = make(&other, 1).unwrap_err().chain();
        assert!(
            told.contains("map 0 in") && told.contains("differs in outlines"),
            "{told}"
        );
        // A plan decides nothing about the data.
        std::fs::write(out.path().join("plan.json"), "damaged").unwrap();
        make(&own, 1).unwrap();
        let told = make(&other, 1).unwrap_err().chain();
        assert!(told.contains("made from another source"), "{told}");
    }
}
