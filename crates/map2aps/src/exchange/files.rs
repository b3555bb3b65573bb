//! Many small files, each of them whole or not there.

use std::fs;
use std::path::Path;

use crate::error::{At, Place, Result};

/// Writes a file under another name and renames it: a killed run leaves no half of it.
///
/// Nothing is synced, which would take longer than the writing; after a power cut a file may be short, so whoever
/// resumes must look at its length.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let partial = path.with_file_name(format!(".{name}.partial"));
    let written = fs::write(&partial, bytes).and_then(|()| fs::rename(&partial, path));
    written.at_file(Place::Writing, path)
}

/// Creates a folder and those above it.
pub fn create_folder(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).at_file(Place::Creating, folder)
}

/// Returns true when a file is there with this length.
pub fn has_length(path: &Path, bytes: u64) -> bool {
    fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() == bytes)
}
