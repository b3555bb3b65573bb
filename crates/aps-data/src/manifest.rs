//! The JSON files: `manifest.json` of a data set and `map.json` of each map.
//!
//! They describe the data, and nothing of the time, place or speed of their making: the same
//! settings give the same bytes.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::arrays::{Counts, arrays_of};
use crate::durable;
use crate::error::{Error, at};
use crate::json;
use crate::layout::Layout;
use crate::split::Split;

#[cfg(test)]
mod fuzz;

/// The version of the format this crate writes, and the newest it reads.
pub const FORMAT_VERSION: u64 = 4;

/// The name by which the manifests of this format are told from other JSON.
pub(crate) const FORMAT: &str = "aps-dataset";

/// File name of the manifest of a data set.
pub(crate) const MANIFEST_FILE: &str = "manifest.json";

/// File name of the manifest of a map.
pub(crate) const MAP_FILE: &str = "map.json";

/// The settings of a data set: everything that decides its bytes but the choice of maps.
///
/// A run is resumed only with equal settings, and each finished map carries them.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct DatasetConfig {
    /// Seed of all random choices.
    pub seed: u64,
    /// Arrays that are stored, and their axes.
    pub layout: Layout,
    /// Other settings, of sampling, tracer and label: a JSON object that only the writer
    /// interprets.
    pub configuration: Value,
}

/// `manifest.json`: the content of a data set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Manifest {
    /// Always `aps-dataset`.
    pub format: String,
    /// Version of the format, [`FORMAT_VERSION`].
    pub format_version: u64,
    /// Seed of all random choices.
    pub seed: u64,
    /// Arrays that are stored, and their axes.
    pub layout: Layout,
    /// Other settings, as given by the writer, with sorted keys.
    pub configuration: Value,
    /// The part each map belongs to.
    pub split: Split,
    /// Sums over all maps.
    pub totals: Totals,
    /// The maps, by ascending id.
    pub maps: Vec<MapEntry>,
}

/// `map.json`: one map's part of the manifest, complete in itself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MapManifest {
    pub format: String,
    pub format_version: u64,
    pub seed: u64,
    pub layout: Layout,
    pub configuration: Value,
    pub map: MapEntry,
}

/// Entry of one map in the manifest.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct MapEntry {
    /// Number of the map.
    pub id: u32,
    /// Number of transmitters.
    pub tx: usize,
    /// Number of receivers.
    pub rx: usize,
    /// Number of links, with or without label.
    pub links: usize,
    /// Number of stored paths.
    pub paths: usize,
    /// Number of interactions of the stored paths.
    pub interactions: usize,
    /// Number of links in each state that occurs, by [`LinkStatus`](crate::LinkStatus)'s name.
    pub status: BTreeMap<String, u64>,
    /// Findings of the writer about the map: a JSON object whose meaning is the writer's affair, or null.
    pub statistics: Value,
    /// The array files.
    pub files: Vec<FileEntry>,
}

/// Entry of one array file in the manifest.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct FileEntry {
    /// File name within the map's folder.
    pub name: String,
    /// NumPy's name of the element type.
    pub dtype: String,
    /// Length of each axis.
    pub shape: Vec<usize>,
    /// Size of the file \[bytes\].
    pub bytes: u64,
    /// SHA-256 of the file, 64 hexadecimal digits.
    pub sha256: String,
}

/// Sums over all maps of a data set.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Totals {
    /// Number of maps.
    pub maps: u64,
    /// Number of links, with or without label.
    pub links: u64,
    /// Number of stored paths.
    pub paths: u64,
    /// Number of interactions of the stored paths.
    pub interactions: u64,
    /// Size of all array files \[bytes\].
    pub bytes: u64,
    /// Number of links in each state that occurs.
    pub status: BTreeMap<String, u64>,
}

impl DatasetConfig {
    /// Refuses what is stored at `path` if this version, with these settings, would not have written it.
    pub(crate) fn must_have_made(
        &self,
        stored: &DatasetConfig,
        format_version: u64,
        path: &Path,
    ) -> Result<(), Error> {
        match format_version {
            FORMAT_VERSION => self.must_equal(stored, path),
            found => Err(Error::OlderFormat {
                path: path.into(),
                found,
                written: FORMAT_VERSION,
            }),
        }
    }

    /// Refuses settings other than those stored at `path`.
    ///
    /// # Errors
    /// [`Error::ConfigMismatch`], which names each that differs.
    pub fn must_equal(&self, stored: &DatasetConfig, path: &Path) -> Result<(), Error> {
        let differences = json::differences(&json!(stored), &json!(self));
        match differences.is_empty() {
            true => Ok(()),
            false => Err(Error::ConfigMismatch {
                path: path.into(),
                differences,
            }),
        }
    }
}

impl Manifest {
    /// Creates the manifest of finished maps, in ascending order; `split` covers exactly these.
    pub(crate) fn new(config: DatasetConfig, split: Split, maps: Vec<MapEntry>) -> Self {
        Manifest {
            format: FORMAT.into(),
            format_version: FORMAT_VERSION,
            seed: config.seed,
            layout: config.layout,
            configuration: config.configuration,
            split: split.sorted(),
            totals: Totals::of(&maps).expect("the links of maps on disk can be counted"),
            maps,
        }
    }

    /// Returns a map of the data set, if it has it.
    pub fn map(&self, id: u32) -> Option<&MapEntry> {
        let found = self.maps.binary_search_by_key(&id, |map| map.id);
        found.ok().map(|index| &self.maps[index])
    }

    /// Returns the settings of the data set.
    pub fn config(&self) -> DatasetConfig {
        DatasetConfig {
            seed: self.seed,
            layout: self.layout,
            configuration: self.configuration.clone(),
        }
    }

    /// Reads a manifest and checks that it agrees with itself.
    pub(crate) fn read(path: &Path) -> Result<Self, Error> {
        Self::parse(path, &json::read_bytes(path)?)
    }

    fn parse(path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let manifest: Self = sound(path, parse(path, bytes)?, Manifest::problem)?;
        Ok(Self {
            split: manifest.split.sorted(),
            ..manifest
        })
    }

    fn problem(&self) -> Option<String> {
        let ids: Vec<u32> = self.maps.iter().map(|map| map.id).collect();
        if let Some(problem) = config_problem(&self.layout, &self.configuration) {
            Some(problem.into())
        } else if !ids.is_sorted_by(|a, b| a < b) {
            Some("maps are not in ascending order".into())
        } else if self.split.all_maps() != ids {
            Some("split does not name every map once".into())
        } else if let Some(problem) = self.maps.iter().find_map(|map| map.problem(&self.layout)) {
            Some(problem)
        } else if Totals::of(&self.maps).as_ref() != Some(&self.totals) {
            Some("totals are not the sums over the maps".into())
        } else {
            None
        }
    }
}

impl MapManifest {
    pub fn new(config: DatasetConfig, map: MapEntry) -> Self {
        MapManifest {
            format: FORMAT.into(),
            format_version: FORMAT_VERSION,
            seed: config.seed,
            layout: config.layout,
            configuration: config.configuration,
            map,
        }
    }

    /// Reads the manifest of map `id` in its folder and checks that it agrees with itself.
    pub fn read_of(id: u32, folder: &Path) -> Result<Self, Error> {
        let path = folder.join(MAP_FILE);
        Self::parse(id, &path, &json::read_bytes(&path)?)
    }

    fn parse(id: u32, path: &Path, bytes: &[u8]) -> Result<Self, Error> {
        sound(path, parse(path, bytes)?, |map: &Self| map.problem(id))
    }

    fn problem(&self, id: u32) -> Option<String> {
        if self.map.id != id {
            Some(format!("it describes map {}", self.map.id))
        } else if let Some(problem) = config_problem(&self.layout, &self.configuration) {
            Some(problem.into())
        } else {
            self.map.problem(&self.layout)
        }
    }

    pub fn config(&self) -> DatasetConfig {
        DatasetConfig {
            seed: self.seed,
            layout: self.layout,
            configuration: self.configuration.clone(),
        }
    }
}

impl FileEntry {
    /// Returns the length of the file in its map's folder, if it is another than was written; nothing is read.
    pub(crate) fn other_length(&self, folder: &Path) -> Result<Option<u64>, Error> {
        let path = folder.join(&self.name);
        let length = fs::metadata(&path).map_err(at(&path, "find"))?.len();
        Ok((length != self.bytes).then_some(length))
    }
}

impl MapEntry {
    /// Returns the number of links with a label.
    pub fn valid(&self) -> u64 {
        self.status.get("valid").copied().unwrap_or(0)
    }

    /// Checks that a map has all its files in full length in its folder, without reading them.
    pub(crate) fn must_be_whole(&self, folder: &Path) -> Result<(), Error> {
        for file in &self.files {
            if let Some(length) = file.other_length(folder)? {
                let path = folder.join(&file.name);
                let problem = format!(
                    "{length} bytes, {} were written; remove its map folder to make it anew",
                    file.bytes
                );
                return Err(Error::Damaged { path, problem });
            }
        }
        Ok(())
    }

    /// Returns the name of a map's folder.
    pub(crate) fn folder_of(id: u32) -> String {
        format!("map_{id:04}")
    }

    /// Returns the map whose folder has this name.
    pub(crate) fn id_of(folder: &str) -> Option<u32> {
        let id = folder.strip_prefix("map_")?.parse().ok()?;
        (Self::folder_of(id) == folder).then_some(id)
    }

    /// Lists the maps in the folder of a data set, with their folders.
    pub(crate) fn folders_in(root: &Path) -> Result<Vec<(u32, PathBuf)>, Error> {
        let names = durable::names_in(root)?;
        Ok(names
            .iter()
            .filter_map(|name| Some((Self::id_of(name)?, root.join(name))))
            .collect())
    }

    pub(crate) fn counts(&self) -> Counts {
        Counts {
            tx: self.tx,
            rx: self.rx,
            links: self.links,
            paths: self.paths,
            interactions: self.interactions,
        }
    }

    /// Returns the entry of an array, by its name without `.npy`.
    pub(crate) fn file(&self, array: &str) -> Option<&FileEntry> {
        self.files
            .iter()
            .find(|file| file.name.strip_suffix(".npy") == Some(array))
    }

    /// Describes a contradiction to the layout or within the entry; `None` if there is none, and then
    /// every file name is a plain one, and every size fits its shape.
    fn problem(&self, layout: &Layout) -> Option<String> {
        let id = self.id;
        let Some(arrays) = arrays_of(layout, &self.counts()) else {
            return Some(format!("map {id}: impossible number of links or paths"));
        };
        if self.files.len() != arrays.len() {
            return Some(format!(
                "map {id}: {} files, its layout has {}",
                self.files.len(),
                arrays.len()
            ));
        }
        for (file, array) in self.files.iter().zip(&arrays) {
            let is_named = file.name.strip_suffix(".npy") == Some(array.name);
            if !is_named || file.dtype != array.dtype || file.shape != array.shape {
                let wanted = format!("{}.npy, {} {:?}", array.name, array.dtype, array.shape);
                let found = format!("{}, {} {:?}", file.name, file.dtype, file.shape);
                return Some(format!("map {id}: expected {wanted}, found {found}"));
            }
            if array.file_bytes() != Some(file.bytes) {
                return Some(format!(
                    "map {id}: {} cannot have {} bytes",
                    file.name, file.bytes
                ));
            }
        }
        let counted = self
            .status
            .values()
            .try_fold(0_u64, |sum, &n| sum.checked_add(n));
        (counted != Some(self.links as u64))
            .then(|| format!("map {id}: status counts do not add up to its links"))
    }
}

impl Totals {
    pub(crate) fn of(maps: &[MapEntry]) -> Option<Self> {
        let mut totals = Totals {
            maps: maps.len() as u64,
            ..Totals::default()
        };
        for map in maps {
            totals.links = totals.links.checked_add(map.links as u64)?;
            totals.paths = totals.paths.checked_add(map.paths as u64)?;
            totals.interactions = totals.interactions.checked_add(map.interactions as u64)?;
            for file in &map.files {
                totals.bytes = totals.bytes.checked_add(file.bytes)?;
            }
            for (name, &count) in &map.status {
                let sum = totals.status.entry(name.clone()).or_insert(0);
                *sum = sum.checked_add(count)?;
            }
        }
        Some(totals)
    }

    /// Returns the number of links with a label.
    pub fn valid(&self) -> u64 {
        self.status.get("valid").copied().unwrap_or(0)
    }
}

/// Describes the fault of the settings of a data set; `None` if there is none.
pub(crate) fn config_problem(layout: &Layout, configuration: &Value) -> Option<&'static str> {
    match configuration {
        Value::Object(_) | Value::Null => layout.problem(),
        _ => Some("the configuration must be a JSON object"),
    }
}

/// Returns a value read from a file, or the fault of the file.
pub(crate) fn sound<T>(
    path: &Path,
    value: T,
    problem: impl FnOnce(&T) -> Option<String>,
) -> Result<T, Error> {
    match problem(&value) {
        Some(problem) => Err(Error::Damaged {
            path: path.into(),
            problem,
        }),
        None => Ok(value),
    }
}

/// Parses a manifest, looking at its version before anything else.
pub(crate) fn parse<T: DeserializeOwned>(path: &Path, bytes: &[u8]) -> Result<T, Error> {
    #[derive(Deserialize)]
    struct Version {
        format: Option<String>,
        format_version: Option<u64>,
    }
    let in_json = |source| Error::Json {
        path: path.into(),
        source,
    };
    let version: Version = serde_json::from_slice(bytes).map_err(in_json)?;
    match (version.format.as_deref(), version.format_version) {
        (Some(FORMAT), Some(found)) if found > FORMAT_VERSION => Err(Error::NewerFormat {
            path: path.into(),
            found,
            supported: FORMAT_VERSION,
        }),
        (Some(FORMAT), Some(1..)) => serde_json::from_slice(bytes).map_err(in_json),
        _ => {
            let path = path.into();
            let problem =
                format!("format and format_version are not {FORMAT:?} and a positive number");
            Err(Error::NotADataset { path, problem })
        }
    }
}
