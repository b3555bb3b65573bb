//! Many small files, each of them whole or not there.

use std::fs;
use std::path::Path;

use anyhow::Result;

/// Writes a file whole or not at all: see [`aps_report::write_whole`].
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    Ok(aps_report::write_whole(path, bytes)?)
}

/// Tells if a file is there with this length.
pub fn has_length(path: &Path, bytes: u64) -> bool {
    fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() == bytes)
}
