//! Many small files, each of them whole or not there.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

/// Writes a file under another name and renames it: a killed run leaves no half of it.
///
/// Nothing is synced, which would take longer than the writing; after a power cut a file may be short, so whoever
/// resumes must look at its length.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let partial = path.with_file_name(format!(".{name}.partial"));
    fs::write(&partial, bytes).with_context(|| format!("cannot write '{}'", partial.display()))?;
    fs::rename(&partial, path).with_context(|| format!("cannot write '{}'", path.display()))
}

/// Whether a file is there with this length.
pub fn has_length(path: &Path, bytes: u64) -> bool {
    fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() == bytes)
}
