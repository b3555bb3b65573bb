//! Files that are always whole.

use std::fs::{self, File};
use std::io;
use std::path::Path;

/// Writes a file such that at any moment the old or the new one is there, whole.
///
/// The partial file has one name, so that the next write takes the place of what a killed one left. Writers of one file must exclude each other.
pub(crate) fn replace(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> io::Result<()> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let partial = folder.join(format!(".{name}.partial"));
    let written = write(&partial)
        .and_then(|()| File::options().write(true).open(&partial)?.sync_all())
        .and_then(|()| fs::rename(&partial, path));
    if written.is_err() {
        // Best effort: the error that matters is the one returned.
        let _ = fs::remove_file(&partial);
    }
    written?;
    match cfg!(unix) {
        true => File::open(folder)?.sync_all(),
        false => Ok(()),
    }
}
