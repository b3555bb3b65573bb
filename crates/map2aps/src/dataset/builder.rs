//! A data set that is being made, map by map.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use aps_data::{Access, DatasetConfig, DatasetWriter, MapEntry, RasterGrid};
use aps_label::Labeler;
use aps_raytrace::Scene;
use aps_raytrace::scene::RepairReport;

use super::map::Run;
use crate::control::{Control, Work};
use crate::error::{At, Error, Place, Result};
use crate::maps::{MapError, ascending, identity};
use crate::tally::Tally;

/// Result of the making of a data set.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Made {
    /// Counts and times over the maps that were made.
    pub tally: Tally,
    /// Time from the first map to the last.
    pub wall: Duration,
    /// Links of each map that was made, and the time from reading the map to its written labels, on all threads.
    pub maps: Vec<(u32, u64, Duration)>,
    /// Repairs of each map whose buildings needed some.
    pub repairs: Vec<(u32, RepairReport)>,
}

impl Made {
    /// Repairs of all maps together.
    pub fn all_repairs(&self) -> RepairReport {
        let reports = self.repairs.iter();
        let repairs = reports.flat_map(|(_, report)| &report.repairs).copied();
        RepairReport {
            repairs: repairs.collect(),
        }
    }
}

/// The result for a map that was made; after a failure or a cancellation the error tells the maps that are kept.
pub fn or_kept<T>(
    made: Result<T>,
    writer: &DatasetWriter,
    folder: &Path,
    control: &Control<'_>,
) -> Result<T> {
    let (kept, folder) = (writer.map_ids().len(), folder.to_owned());
    match made {
        _ if control.is_cancelled() => Err(Error::Interrupted { kept, folder }),
        Ok(made) => Ok(made),
        Err(error) => Err(Error::Stopped {
            kept,
            folder,
            source: Box::new(error),
        }),
    }
}

/// A data set that is being made, with the maps left to do.
pub struct DatasetBuilder {
    pub writer: DatasetWriter,
    labeler: Labeler,
    folder: PathBuf,
    /// Maps of the data set, of all shards.
    maps: Vec<u32>,
    /// Maps that this writer may write.
    own: Vec<u32>,
    /// Maps that this writer may write and that are not there yet.
    pub todo: Vec<u32>,
    shards: Option<u32>,
}

impl DatasetBuilder {
    pub fn open(
        folder: &Path,
        config: DatasetConfig,
        labeler: Labeler,
        maps: &[u32],
        access: Access,
    ) -> Result<Self> {
        let writer =
            DatasetWriter::open_with(folder, config, access).at_file(Place::Dataset, folder)?;
        let maps = ascending(maps.iter().copied());
        let mut todo = maps.clone();
        todo.retain(|&id| access.covers(id));
        let own = todo.clone();
        todo.retain(|&id| !writer.has_map(id));
        Ok(Self {
            writer,
            labeler,
            folder: folder.into(),
            maps,
            own,
            todo,
            shards: match access {
                Access::Whole => None,
                Access::Shard { count, .. } => Some(count),
            },
        })
    }

    /// The maps that are there or are to be made, of all shards, ascending.
    pub fn all(&self) -> Vec<u32> {
        ascending(
            self.writer
                .map_ids()
                .into_iter()
                .chain(self.maps.iter().copied()),
        )
    }

    /// The maps that are there and can be compared with their source: those of this writer, and the first of all shards.
    pub fn there(&self) -> impl Iterator<Item = MapEntry> {
        let first = self.maps.iter().find(|&&id| self.writer.has_map(id));
        let others = first.filter(|first| !self.own.contains(first));
        let ids = others.into_iter().chain(&self.own);
        ids.filter_map(|&id| self.writer.entry(id))
    }

    /// Refuses a source in which a map that is there has another file of this name.
    pub fn must_have(&self, map: &MapEntry, file: &str, sha256: &str) -> Result<(), MapError> {
        let mut files = map.files.iter();
        match files.any(|stored| stored.name == file && stored.sha256 != sha256) {
            true => Err(self.other_source(map.id, file)),
            false => Ok(()),
        }
    }

    /// Refuses a scene that a map which is there was not made of.
    pub fn must_be_of(&self, map: &MapEntry, scene: &Scene, grid: RasterGrid) -> Result<()> {
        match identity::contradicted(map, scene, grid)? {
            Some(what) => Err(self.other_source(map.id, what).into()),
            None => Ok(()),
        }
    }

    /// Refuses a source in which a map that is there has other outlines, where both are known.
    pub fn must_have_outlines(&self, map: &MapEntry, given: Option<&str>) -> Result<(), MapError> {
        match (identity::stored_outlines(map), given) {
            (Some(stored), Some(given)) if stored != given => {
                Err(self.other_source(map.id, identity::OUTLINES))
            }
            _ => Ok(()),
        }
    }

    fn other_source(&self, id: u32, what: &str) -> MapError {
        MapError::OtherSource {
            id,
            what: what.into(),
            folder: self.folder.clone(),
        }
    }

    /// Makes the maps left to do, which have so many links, one after the other.
    pub fn run(
        &self,
        links: u64,
        control: &Control<'_>,
        mut make: impl FnMut(&Run<'_>, u32) -> Result<Tally>,
    ) -> Result<Made> {
        if self.maps.iter().any(|&id| !self.writer.has_map(id)) {
            let plan = control.plan(self.maps.clone(), self.shards);
            self.writer.set_plan(&plan)?;
        }
        control.progress.begin(Work {
            units: links,
            name: "links",
            finished_maps: self.own.len() - self.todo.len(),
            maps: self.own.len(),
        });
        let run = Run {
            writer: &self.writer,
            labeler: &self.labeler,
            control,
        };
        let started = Instant::now();
        let mut made = Made::default();
        for &id in &self.todo {
            control.progress.map(id);
            let began = Instant::now();
            let tally = make(&run, id);
            let tally = or_kept(tally, &self.writer, &self.folder, control)?;
            made.maps.push((id, tally.links, began.elapsed()));
            made.tally.add(&tally);
        }
        made.wall = started.elapsed();
        Ok(made)
    }
}
