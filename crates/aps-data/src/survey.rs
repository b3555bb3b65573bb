//! Survey of a data set in a folder, finished or not.

use std::path::Path;

use crate::error::Error;
use crate::manifest::{
    DatasetConfig, MANIFEST_FILE, MAP_FILE, Manifest, MapEntry, MapManifest, Totals,
};
use crate::plan::Plan;

/// Manifest, plan and whole maps of a data set that may be unfinished, from their JSON alone; nothing
/// is locked or changed.
///
/// ```
/// use aps_data::{Access, DatasetConfig, DatasetWriter, Plan, Survey};
///
/// let root = tempfile::tempdir()?;
/// let shard = Access::Shard { index: 0, count: 2 };
/// let writer = DatasetWriter::open_with(root.path(), DatasetConfig::default(), shard)?;
/// writer.set_plan(&Plan { maps: vec![0, 1, 2], shards: Some(2), command: Vec::new() })?;
///
/// let survey = Survey::of(root.path())?;
/// assert!(survey.manifest.is_none());
/// assert_eq!(survey.missing(), [0, 1, 2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Survey {
    /// The manifest, if the data set is finished.
    pub manifest: Option<Manifest>,
    /// Plan of a run that has not finished, if it wrote one.
    pub plan: Option<Plan>,
    /// The settings of all whole maps; `None` before the first.
    pub config: Option<DatasetConfig>,
    /// The whole maps, by ascending id.
    pub maps: Vec<MapEntry>,
    /// Sums over the whole maps.
    pub totals: Totals,
}

impl Survey {
    /// Looks into a folder.
    ///
    /// # Errors
    /// [`Error::NotADataset`] when it holds nothing of a data set; [`Error::ConfigMismatch`] when
    /// its maps were made with different settings; [`Error::Io`], [`Error::Json`],
    /// [`Error::NewerFormat`] and [`Error::Damaged`] for JSON that is not as written.
    pub fn of(root: impl AsRef<Path>) -> Result<Self, Error> {
        let root = root.as_ref();
        let plan = Plan::read(root)?;
        let path = root.join(MANIFEST_FILE);
        let manifest = path.is_file().then(|| Manifest::read(&path)).transpose()?;
        let mut config = manifest.as_ref().map(Manifest::config);
        let mut maps = Vec::new();
        for (id, folder) in MapEntry::folders_in(root)? {
            let stored = MapManifest::read_of(id, &folder)?;
            match &config {
                Some(config) => config.must_equal(&stored.config(), &folder.join(MAP_FILE))?,
                None => config = Some(stored.config()),
            }
            maps.push(stored.map);
        }
        maps.sort_unstable_by_key(|map| map.id);
        if plan.is_none() && manifest.is_none() && maps.is_empty() {
            return Err(Error::NotADataset {
                path: root.into(),
                problem: "it has neither a manifest nor a map".into(),
            });
        }
        let totals = Totals::of(&maps).ok_or_else(|| Error::Damaged {
            path: root.into(),
            problem: "its maps have more bytes than can be counted".into(),
        })?;
        Ok(Survey {
            manifest,
            plan,
            config,
            maps,
            totals,
        })
    }

    /// Returns the maps of the data set when finished: maps of the plan and maps that exist.
    pub fn wanted(&self) -> Vec<u32> {
        let planned = self.plan.iter().flat_map(|plan| plan.maps.iter().copied());
        let mut ids: Vec<u32> = planned.chain(self.maps.iter().map(|map| map.id)).collect();
        ids.sort_unstable();
        ids.dedup();
        ids
    }

    /// Returns the maps that are still missing.
    pub fn missing(&self) -> Vec<u32> {
        let mut wanted = self.wanted();
        wanted.retain(|&id| self.maps.binary_search_by_key(&id, |map| map.id).is_err());
        wanted
    }
}
