//! Files that are always whole.

use std::collections::hash_map::RandomState;
use std::fs::{self, File};
use std::hash::{BuildHasher, Hasher};
use std::io;
use std::path::Path;
use std::sync::LazyLock;

/// Random number of this process, since processes that write the same file must not meet. In containers process numbers may be equal.
static WRITER: LazyLock<u64> = LazyLock::new(|| RandomState::new().build_hasher().finish());

/// Writes a file such that at any moment the old or the new one is there, whole.
pub(crate) fn replace(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> io::Result<()> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let partial = folder.join(format!(".{name}.partial-{:016x}", *WRITER));
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
