//! Errors of shards that are to be joined.

use std::path::PathBuf;

use aps_data::Access;

/// Fault of shards that are to be joined.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// No folder given, and none in the place of the result.
    #[error("give the folders of the shards")]
    NoFolder,
    /// Folders without a whole map.
    #[error("no map is finished in {}", names(.0))]
    NoMap(Vec<PathBuf>),
    /// A map that two folders hold with other bytes.
    #[error(
        "map {map} in '{}' is not that in '{}': they are of different maps or programs; leave one folder out, or remove the map from it",
        folders[0].display(), folders[1].display()
    )]
    Differ {
        /// The map.
        map: u32,
        /// The folders.
        folders: [PathBuf; 2],
    },
    /// Maps that were planned and are in none of the folders.
    #[error("maps {maps:?} are in none of {}; make them first", names(folders))]
    Missing {
        /// The maps.
        maps: Vec<u32>,
        /// The folders.
        folders: Vec<PathBuf>,
        /// Runs that make the maps.
        parts: Vec<MissingPart>,
    },
}

/// A run that makes missing maps.
#[derive(Debug, Clone, PartialEq)]
pub struct MissingPart {
    /// Command that makes the data set, without shard and folder, as its plan keeps it.
    pub command: Vec<String>,
    /// Shard to make.
    pub shard: Access,
    /// Folder to make it in.
    pub folder: PathBuf,
}

fn names(folders: &[PathBuf]) -> String {
    let name = |folder: &PathBuf| format!("'{}'", folder.display());
    folders.iter().map(name).collect::<Vec<_>>().join(", ")
}
