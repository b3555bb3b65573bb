//! The folder of a data set that is being written.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::manifest::{DatasetConfig, MapEntry};

/// Place, settings and whole maps of a data set that is being written.
#[derive(Debug)]
pub(crate) struct DatasetFolder {
    pub root: PathBuf,
    pub config: DatasetConfig,
    finished: Mutex<BTreeMap<u32, MapEntry>>,
}

impl DatasetFolder {
    pub fn new(root: &Path, config: DatasetConfig, finished: BTreeMap<u32, MapEntry>) -> Self {
        Self {
            root: root.to_path_buf(),
            config,
            finished: Mutex::new(finished),
        }
    }

    /// Adds a whole map.
    pub fn register(&self, entry: MapEntry) {
        self.finished().insert(entry.id, entry);
    }

    /// Returns the whole maps by number.
    pub fn finished(&self) -> MutexGuard<'_, BTreeMap<u32, MapEntry>> {
        // Entries are inserted whole, so a thread that panicked elsewhere left nothing half-done here.
        self.finished.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
