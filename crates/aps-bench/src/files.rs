//! Files of a benchmark: JSON, and the mark of its folder.

use std::fs;
use std::path::Path;

use aps_data::LOCK_FILE;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Writes a value as JSON, whole or not at all.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value)? + "\n";
    Ok(aps_data::replace_file(path, text.as_bytes())?)
}

/// Reads a value from JSON.
pub fn read_json<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T> {
    let text = fs::read_to_string(path).map_err(Error::file("file", path))?;
    serde_json::from_str(&text).map_err(Error::file("file", path))
}

/// Marks a folder as a benchmark's, so that nothing else is ever removed from it, and locks it.
pub fn claim_folder(folder: &Path, settings: &impl Serialize) -> Result<fs::File> {
    let marker = folder.join("configuration.json");
    fs::create_dir_all(folder).map_err(Error::file("folder", folder))?;
    let mut names = fs::read_dir(folder).map_err(Error::file("folder", folder))?;
    let is_foreign = |name: &fs::DirEntry| name.file_name() != LOCK_FILE;
    if names.any(|name| name.as_ref().is_ok_and(is_foreign)) && !marker.is_file() {
        return Err(Error::ForeignFolder(folder.into()));
    }
    let lock = aps_data::lock_folder(folder)?;
    write_json(&marker, settings)?;
    Ok(lock)
}
