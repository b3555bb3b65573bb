//! The folder of an export.

use std::fs;
use std::path::Path;

use aps_data::is_partial;

use crate::error::{At, Place, Result};
use crate::exchange::ExchangeError;

/// Result of an export.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Exported {
    /// Links in the folder.
    pub links: usize,
    /// Bytes of the links' files written, without those that were there.
    pub bytes: u64,
}

/// Refuses a folder with anything in it that is not hidden, as version control and file managers keep theirs.
pub fn must_be_empty(folder: &Path) -> Result<()> {
    for entry in fs::read_dir(folder).at_file(Place::Reading, folder)? {
        let name = entry.at_file(Place::Reading, folder)?.file_name();
        if !name.as_encoded_bytes().starts_with(b".") {
            return Err(ExchangeError::NotEmpty(folder.into()).into());
        }
    }
    Ok(())
}

/// Removes what an export that was killed left half-written in a folder and those below. The folder is locked.
pub fn remove_partial_files(folder: &Path) -> Result<()> {
    for entry in fs::read_dir(folder).at_file(Place::Reading, folder)? {
        let entry = entry.at_file(Place::Reading, folder)?;
        let path = entry.path();
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            remove_partial_files(&path)?;
        } else if is_partial(entry.file_name()) {
            match fs::remove_file(&path) {
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
                removed => removed.at_file(Place::Removing, &path)?,
            }
        }
    }
    Ok(())
}

/// Creates a folder and those above it.
pub fn create_folder(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).at_file(Place::Creating, folder)
}
