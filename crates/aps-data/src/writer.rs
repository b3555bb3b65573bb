//! Writing a data set: one folder, one lock, any number of maps.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;

use crate::dataset_folder::DatasetFolder;
use crate::durable::{self, LOCK_FILE, PartialFolder};
use crate::error::{Error, at};
use crate::json;
use crate::manifest::{
    self, DatasetConfig, MANIFEST_FILE, MAP_FILE, Manifest, MapEntry, MapManifest,
};
use crate::map_writer::{MapInput, MapWriter};
use crate::plan::{PLAN_FILE, Plan};
use crate::split::Split;

/// Maps that a writer may write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Access {
    /// Every map: no other writer may be at work in the same folder.
    #[default]
    Whole,
    /// Maps with `id % count == index`, beside the writers of other shards of the same count.
    Shard {
        /// Number of the shard, below `count`.
        index: u32,
        /// Number of shards, positive.
        count: u32,
    },
}

impl Access {
    /// Returns true when the writer may write this map.
    pub fn covers(self, id: u32) -> bool {
        match self {
            Access::Whole => true,
            Access::Shard { index, count } => count > 0 && id % count == index,
        }
    }
}

/// Writes a data set, map by map; starting again where an earlier run ended.
///
/// Several maps may be under way at once, from several threads. See the crate's documentation for
/// an example.
#[derive(Debug)]
pub struct DatasetWriter {
    folder: DatasetFolder,
    access: Access,
    /// Held until the writer is dropped.
    _locks: Vec<File>,
}

impl DatasetWriter {
    /// Creates a data set in `root`, or opens the one begun there for more maps.
    ///
    /// The folder must not exist, be empty, or hold a data set of equal settings. What a killed run
    /// left half-written is removed; whole maps are kept and not written again.
    ///
    /// # Errors
    /// [`Error::Locked`] when another writer is at work, [`Error::ConfigMismatch`] when a finished
    /// map was made with other settings, [`Error::NotADataset`] when the folder holds something
    /// else, [`Error::Config`], [`Error::Io`], and all that reading the manifests found there may
    /// return.
    pub fn open(root: impl AsRef<Path>, config: DatasetConfig) -> Result<Self, Error> {
        Self::open_with(root, config, Access::Whole)
    }

    /// As [`DatasetWriter::open`], for one of several writers that share the maps.
    ///
    /// When all shards are done, a writer opened for the whole folder writes the manifest by
    /// [`DatasetWriter::finish`]; the result is what one run would have written.
    ///
    /// # Errors
    /// As [`DatasetWriter::open`].
    pub fn open_with(
        root: impl AsRef<Path>,
        mut config: DatasetConfig,
        access: Access,
    ) -> Result<Self, Error> {
        let root = root.as_ref();
        if let Some(problem) = config_problem(&config, access) {
            return Err(Error::Config {
                problem: problem.into(),
            });
        }
        fs::create_dir_all(root).map_err(at(root, "create"))?;
        let mut names = durable::names_in(root)?;
        // Other folders are locked too, and other files replaced whole.
        names.retain(|name| !durable::is_temporary(name));
        if let [first, ..] = &names[..]
            && !names.iter().any(|name| is_of_dataset(name))
        {
            let problem = format!("it holds {first:?} and the like; give an empty or a new folder");
            return Err(Error::NotADataset {
                path: root.into(),
                problem,
            });
        }
        let locks = take_locks(root, access)?;
        if access == Access::Whole {
            PartialFolder::remove_leftovers(root)?;
        }
        // The order in which they are stored.
        config.configuration.sort_all_objects();
        let finished = finished_maps(root, &config)?;
        Ok(DatasetWriter {
            folder: DatasetFolder::new(root, config, finished),
            access,
            _locks: locks,
        })
    }

    /// Returns the settings of the data set.
    pub fn config(&self) -> &DatasetConfig {
        &self.folder.config
    }

    /// Returns true when the data set holds the whole map.
    pub fn has_map(&self, id: u32) -> bool {
        self.folder.finished().contains_key(&id)
    }

    /// Returns the entry of a whole map of the data set.
    pub fn entry(&self, id: u32) -> Option<MapEntry> {
        self.folder.finished().get(&id).cloned()
    }

    /// Returns the whole maps of the data set, in ascending order.
    pub fn map_ids(&self) -> Vec<u32> {
        self.folder.finished().keys().copied().collect()
    }

    /// Starts a map. Its links follow by [`MapWriter::push`]; it is part of the data set after
    /// [`MapWriter::finish`].
    ///
    /// # Errors
    /// [`Error::Input`] when the map is there already, belongs to another shard, or its points,
    /// links or raster make no sense; [`Error::Io`].
    pub fn begin_map(&self, id: u32, input: &MapInput<'_>) -> Result<MapWriter<'_>, Error> {
        self.must_want(id)?;
        MapWriter::begin(&self.folder, id, input)
    }

    /// Writes the plan of the run, for readers of the unfinished data set; shards in one folder all
    /// write the same plan. [`DatasetWriter::finish`] removes it.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn set_plan(&self, plan: &Plan) -> Result<(), Error> {
        plan.write(&self.folder.root)
    }

    /// Writes the manifest over all finished maps, which the split must name, each once.
    ///
    /// # Errors
    /// [`Error::Config`] when split and finished maps differ; [`Error::Io`]. The maps stay as they
    /// are.
    pub fn finish(self, split: &Split) -> Result<Manifest, Error> {
        let maps: Vec<MapEntry> = self.folder.finished().values().cloned().collect();
        let ids: Vec<u32> = maps.iter().map(|map| map.id).collect();
        let named = split.all_maps();
        if named != ids {
            let only = |a: &[u32], b: &[u32]| -> Vec<u32> {
                let only = a.iter().filter(|id| !b.contains(id));
                only.copied().collect()
            };
            let (missing, surplus) = (only(&named, &ids), only(&ids, &named));
            let problem = format!(
                "the split must name each finished map once; not finished: {missing:?}, not in the split: {surplus:?}"
            );
            return Err(Error::Config { problem });
        }
        let manifest = Manifest::new(self.folder.config.clone(), split.clone(), maps);
        durable::replace_file(
            &self.folder.root.join(MANIFEST_FILE),
            &json::to_bytes(&manifest),
        )?;
        durable::remove_file(&self.folder.root.join(PLAN_FILE))?;
        Ok(manifest)
    }

    /// Refuses finished maps and those of other shards.
    pub(crate) fn must_want(&self, id: u32) -> Result<(), Error> {
        let refuse = |problem: &str| Error::Input {
            map: id,
            problem: problem.into(),
        };
        if self.has_map(id) {
            Err(refuse("already written; ask has_map first"))
        } else if !self.access.covers(id) {
            Err(refuse("belongs to another shard"))
        } else {
            Ok(())
        }
    }

    /// Returns what map writers need of the data set.
    pub(crate) fn folder(&self) -> &DatasetFolder {
        &self.folder
    }
}

fn config_problem(config: &DatasetConfig, access: Access) -> Option<&'static str> {
    let is_shard_of_none = matches!(access, Access::Shard { index, count } if index >= count);
    if is_shard_of_none {
        Some("a shard's number must be below the number of shards")
    } else {
        manifest::config_problem(&config.layout, &config.configuration)
    }
}

fn take_locks(root: &Path, access: Access) -> Result<Vec<File>, Error> {
    let whole = root.join(LOCK_FILE);
    match access {
        Access::Whole => Ok(vec![durable::lock(&whole, false)?]),
        Access::Shard { index, count } => {
            let own = root.join(format!("{LOCK_FILE}.{index}-of-{count}"));
            Ok(vec![
                durable::lock(&whole, true)?,
                durable::lock(&own, false)?,
            ])
        }
    }
}

/// Returns true when a file or folder of this name belongs to a data set.
fn is_of_dataset(name: &str) -> bool {
    [MANIFEST_FILE, PLAN_FILE].contains(&name) || MapEntry::id_of(name).is_some()
}

/// Finds the whole maps in a folder, all made with the given settings.
fn finished_maps(root: &Path, config: &DatasetConfig) -> Result<BTreeMap<u32, MapEntry>, Error> {
    let path = root.join(MANIFEST_FILE);
    if path.exists() {
        let stored = Manifest::read(&path)?;
        config.must_have_made(&stored.config(), stored.format_version, &path)?;
    }
    let mut finished = BTreeMap::new();
    for (id, folder) in MapEntry::folders_in(root)? {
        let stored = MapManifest::read_of(id, &folder)?;
        let path = folder.join(MAP_FILE);
        config.must_have_made(&stored.config(), stored.format_version, &path)?;
        stored.map.must_be_whole(&folder)?;
        finished.insert(id, stored.map);
    }
    Ok(finished)
}
