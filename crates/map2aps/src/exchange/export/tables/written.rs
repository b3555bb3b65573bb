//! Files of the tables, written or taken as they are.

use std::path::Path;

use aps_data::{Part, replace_unsynced, sha256_of};

use super::file;
use crate::error::{At, Place, Result};

/// A file that was written.
pub struct Written {
    /// Place within the export.
    pub name: String,
    pub part: Option<Part>,
    pub rows: usize,
    pub bytes: u64,
    pub sha256: String,
}

impl Written {
    /// Writes a file of so many rows, or takes the one that is there and whole.
    pub fn make(
        out: &Path,
        name: String,
        part: Option<Part>,
        rows: usize,
        make: impl FnOnce() -> Result<Vec<u8>>,
    ) -> Result<Self> {
        let path = out.join(&name);
        let bytes = match file::whole(&path, rows) {
            Some(bytes) => bytes,
            None => {
                let bytes = make().at(Place::Writing(path.clone()))?;
                replace_unsynced(&path, &bytes)?;
                bytes
            }
        };
        Ok(Self::of(name, part, rows, &bytes))
    }

    /// A file of so many rows with these bytes.
    pub fn of(name: String, part: Option<Part>, rows: usize, bytes: &[u8]) -> Self {
        Self {
            name,
            part,
            rows,
            bytes: bytes.len() as u64,
            sha256: sha256_of(bytes),
        }
    }
}
