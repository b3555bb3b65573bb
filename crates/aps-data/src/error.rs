//! Errors of reading and writing a data set.

use std::io;
use std::path::{Path, PathBuf};

use crate::npy::NpyError;

/// Errors of reading and writing a data set; the message names the file, and the remedy where that
/// is not plain. The cause, where there is one, is the error's source.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused something: a full disk, a read-only folder, a file that is not
    /// there.
    #[error("cannot {action} {}", path.display())]
    Io {
        /// Action that failed, as a verb.
        action: &'static str,
        /// File or folder of the action.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// An array file is not what it should be.
    #[error("{} is not an array as it should be", path.display())]
    Npy {
        /// The array file.
        path: PathBuf,
        /// Fault of the file.
        source: NpyError,
    },
    /// A manifest is not the JSON it should be.
    #[error("{} is not a manifest as it should be", path.display())]
    Json {
        /// The manifest.
        path: PathBuf,
        /// Fault of the file.
        source: serde_json::Error,
    },
    /// The folder holds something else than a data set.
    #[error("{} is not a data set: {problem}", path.display())]
    NotADataset {
        /// The folder.
        path: PathBuf,
        /// Description of the fault.
        problem: String,
    },
    /// The data set was written by a later version of this crate.
    #[error("{} has format version {found}, this program reads up to {supported}; use a newer one", path.display())]
    NewerFormat {
        /// The manifest.
        path: PathBuf,
        /// Version in the manifest.
        found: u64,
        /// Newest version this crate knows.
        supported: u64,
    },
    /// The stored data were written by an earlier version of this crate, whose bytes this one does not repeat.
    #[error("{} has format version {found}, this program writes {written}: finish it with the program that began it, or use another folder", path.display())]
    OlderFormat {
        /// The manifest.
        path: PathBuf,
        /// Version in the manifest.
        found: u64,
        /// Version this crate writes.
        written: u64,
    },
    /// The stored data contradict themselves.
    #[error("{} is damaged: {problem}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The contradiction.
        problem: String,
    },
    /// The bytes of a file are not those that were written.
    #[error("{} is damaged: its SHA-256 is {found}, the manifest says {stored}", path.display())]
    Checksum {
        /// The file.
        path: PathBuf,
        /// Checksum in the manifest.
        stored: String,
        /// Checksum of the file.
        found: String,
    },
    /// The folder holds maps made with other settings.
    #[error(
        "{} was made with other settings: {}; use the same ones or another folder",
        path.display(),
        listed(differences)
    )]
    ConfigMismatch {
        /// Manifest of the finished map or data set, or settings of a run.
        path: PathBuf,
        /// Every setting that differs, at least one.
        differences: Vec<Difference>,
    },
    /// Another process writes to the folder.
    #[error("{} is locked: another run writes into this folder; wait for it, or use another one", path.display())]
    Locked {
        /// The lock file.
        path: PathBuf,
    },
    /// The settings of a data set to write make no sense.
    #[error("cannot write such a data set: {problem}")]
    Config {
        /// Fault of the settings.
        problem: String,
    },
    /// The data of a map to write make no sense.
    #[error("map {map}: {problem}")]
    Input {
        /// The map.
        map: u32,
        /// Fault and its place.
        problem: String,
    },
    /// Rows of links do not fit the layout they are to be stored in.
    #[error("cannot store such rows: {problem}")]
    Rows {
        /// Fault and its place.
        problem: String,
    },
    /// A map asked for is not in the data set.
    #[error("{} has no map {map}", path.display())]
    UnknownMap {
        /// The data set.
        path: PathBuf,
        /// The map asked for.
        map: u32,
    },
    /// An array asked for is not stored in this data set.
    #[error("{} does not store {what}; write the data set with them", path.display())]
    NotStored {
        /// The data set.
        path: PathBuf,
        /// Arrays asked for.
        what: &'static str,
    },
}

/// A setting that differs between a folder and a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// Path of the setting, e.g. `configuration.tracer.max_reflections`.
    pub key: String,
    /// Value in the folder, as JSON, or `nothing`.
    pub stored: String,
    /// Value in this run, as JSON, or `nothing`.
    pub given: String,
}

fn listed(differences: &[Difference]) -> String {
    let one = |d: &Difference| format!("{} is {} there, {} here", d.key, d.stored, d.given);
    differences.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// Adds action and path to an I/O error.
pub(crate) fn at(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Error + use<> {
    let path = path.to_path_buf();
    move |source| Error::Io {
        action,
        path,
        source,
    }
}

/// Adds action and path to an error in an array file.
pub(crate) fn in_array(
    path: &Path,
    action: &'static str,
) -> impl FnOnce(NpyError) -> Error + use<> {
    let path = path.to_path_buf();
    move |source| match source {
        NpyError::Io(source) => at(&path, action)(source),
        source => Error::Npy { path, source },
    }
}
