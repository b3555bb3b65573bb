//! Files and folders that are there whole or not at all, also after a crash.

use std::collections::hash_map::RandomState;
use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::hash::{BuildHasher, Hasher};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

use sha2::{Digest, Sha256};

use crate::error::{Error, at};

/// The file a writer locks in its folder; shards lock one each, named after it.
pub const LOCK_FILE: &str = ".lock";

/// Makes the entries of a folder survive a power cut. Only Unix needs and allows it.
pub(crate) fn sync_folder(path: &Path) -> Result<(), Error> {
    if cfg!(unix) {
        File::open(path)
            .and_then(|folder| folder.sync_all())
            .map_err(at(path, "sync"))?;
    }
    Ok(())
}

/// Creates a file with these bytes, on disk when this returns.
pub(crate) fn write_synced(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let mut file = File::create(path).map_err(at(path, "create"))?;
    file.write_all(bytes)
        .and_then(|()| file.sync_all())
        .map_err(at(path, "write"))
}

/// Removes a file, if it is there.
pub(crate) fn remove_file(path: &Path) -> Result<(), Error> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => Err(at(path, "remove")(source)),
        _ => sync_folder(folder_of(path)),
    }
}

/// Creates or replaces a file such that at any moment, also after a power cut, either the old or the new one is there,
/// whole.
///
/// # Errors
/// [`Error::Io`]; the file is then as it was.
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let (partial, mut file) = PartialFile::create(path)?;
    file.write_all(bytes).map_err(at(path, "write"))?;
    partial.complete(file)
}

/// Creates or replaces a file such that a killed program leaves either the old or the new one, whole.
///
/// Nothing is synced, which would take longer than the writing of many small files: after a power cut the file may be
/// short, so a program that resumes must look at its length.
///
/// # Errors
/// [`Error::Io`]; the file is then as it was.
pub fn replace_unsynced(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let (partial, mut file) = PartialFile::create(path)?;
    file.write_all(bytes).map_err(at(path, "write"))?;
    partial.rename(file)
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// The file that a path stands for, there or not: the end of its links. One look where it is no link, for whoever writes many.
fn file_of(path: &Path) -> io::Result<PathBuf> {
    match fs::symlink_metadata(path) {
        Ok(there) if there.is_symlink() => {
            // The system refuses links in a circle; at the end of others there may be nothing yet.
            match fs::metadata(path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
                _ => file_of(&folder_of(path).join(fs::read_link(path)?)),
            }
        }
        Ok(there) if !there.is_file() => {
            let told = "it is no file, so it cannot be replaced by one";
            Err(io::Error::new(io::ErrorKind::InvalidInput, told))
        }
        _ => Ok(path.into()),
    }
}

/// Name under which this process writes a file: shards that write the same one must not meet.
fn partial_path(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}{PARTIAL}{:016x}", *WRITER))
}

/// A file under construction under another name, beside the one that it is to replace; removed when dropped before
/// [`PartialFile::complete`]. A killed program leaves it, as `.NAME.partial-` and a number. A process may have one of a name at a time.
///
/// ```
/// use std::io::Write;
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("spectra.npy");
/// let (partial, mut file) = aps_data::PartialFile::create(&path)?;
/// file.write_all(b"some bytes")?;
/// partial.complete(file)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct PartialFile {
    path: PathBuf,
    target: PathBuf,
}

impl PartialFile {
    /// Starts a file that is to become `target`, or where that is a link, the file that it leads to.
    ///
    /// # Errors
    /// [`Error::Io`] for a folder that is not there or may not be written, and for something that is no file, as a device or a pipe:
    /// it would be replaced, not written to.
    pub fn create(target: &Path) -> Result<(Self, File), Error> {
        let create = || {
            let target = file_of(target)?;
            let path = partial_path(&target);
            let file = File::create(&path)?;
            Ok((Self { path, target }, file))
        };
        create().map_err(at(target, "create"))
    }

    /// Gives the file its name, when its bytes are on disk: whole, also after a power cut.
    ///
    /// # Errors
    /// [`Error::Io`]; the target is then as it was.
    pub fn complete(self, file: File) -> Result<(), Error> {
        file.sync_all().map_err(at(&self.target, "write"))?;
        let target = self.target.clone();
        self.rename(file)?;
        sync_folder(folder_of(&target))
    }

    fn rename(self, file: File) -> Result<(), Error> {
        // Some systems rename no file that is open.
        drop(file);
        fs::rename(&self.path, &self.target).map_err(at(&self.target, "rename a file to"))
    }
}

impl Drop for PartialFile {
    fn drop(&mut self) {
        // After `complete` there is nothing left under this name.
        let _ = fs::remove_file(&self.path);
    }
}

/// A folder under construction; removed when dropped before [`PartialFolder::complete`].
#[derive(Debug)]
pub(crate) struct PartialFolder {
    path: PathBuf,
    target: PathBuf,
}

impl PartialFolder {
    /// Starts a folder that is to become `root/name`.
    pub fn create(root: &Path, name: &str) -> Result<Self, Error> {
        static FOLDERS: AtomicU64 = AtomicU64::new(0);
        // Two shards may both be given the same map, and so may two threads.
        let number = FOLDERS.fetch_add(1, Ordering::Relaxed);
        let path = root.join(format!(".{name}{PARTIAL}{:016x}-{number}", *WRITER));
        fs::create_dir(&path).map_err(at(&path, "create"))?;
        Ok(PartialFolder {
            path,
            target: root.join(name),
        })
    }

    /// The folder as it is now.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the folder its final name; all files in it must be synced.
    pub fn complete(self) -> Result<(), Error> {
        sync_folder(&self.path)?;
        fs::rename(&self.path, &self.target).map_err(at(&self.target, "rename a folder to"))?;
        sync_folder(folder_of(&self.target))
    }

    /// Removes what killed runs and finished shards left in `root`. Nothing else may be writing
    /// there.
    pub fn remove_leftovers(root: &Path) -> Result<(), Error> {
        for name in names_in(root)? {
            let path = root.join(&name);
            if is_partial(&name) && name.starts_with(".map_") && path.is_dir() {
                fs::remove_dir_all(&path).map_err(at(&path, "remove"))?;
            } else if is_partial(&name) && name.contains(".json") || is_lock_of_shard(&name) {
                remove_file(&path)?;
            }
        }
        Ok(())
    }
}

const PARTIAL: &str = ".partial-";

/// Returns true for the name of a file that [`PartialFile`] has not given its own yet, or never will if its process was killed.
pub fn is_partial(name: impl AsRef<OsStr>) -> bool {
    let name = name.as_ref().to_string_lossy();
    name.starts_with('.') && name.contains(PARTIAL)
}

/// A random number of this process. Process numbers would not do: in containers, and on the machines of a cluster, many
/// processes that share a folder have the same.
static WRITER: LazyLock<u64> = LazyLock::new(|| RandomState::new().build_hasher().finish());

impl Drop for PartialFolder {
    fn drop(&mut self) {
        // After `complete` there is nothing left under this name. If removal fails the next run tries again.
        let _ = fs::remove_dir_all(&self.path);
    }
}

fn is_lock_of_shard(name: &str) -> bool {
    name.strip_prefix(LOCK_FILE)
        .is_some_and(|rest| rest.starts_with('.'))
}

/// Tells if a file or folder of this name is a lock, or under construction.
pub(crate) fn is_temporary(name: &str) -> bool {
    name == LOCK_FILE || is_lock_of_shard(name) || is_partial(name)
}

/// The names of a folder's entries, sorted. What is not Unicode is replaced, so that such a name is none of ours.
pub(crate) fn names_in(folder: &Path) -> Result<Vec<String>, Error> {
    let entries = fs::read_dir(folder).map_err(at(folder, "list"))?;
    let mut names = Vec::new();
    for entry in entries {
        let entry = entry.map_err(at(folder, "list"))?;
        names.push(entry.file_name().to_string_lossy().into_owned());
    }
    names.sort_unstable();
    Ok(names)
}

/// Takes a lock that ends with the returned file, or with the process.
///
/// The empty file stays: removing it could let two processes lock two files of the same name.
pub(crate) fn lock(path: &Path, shared: bool) -> Result<File, Error> {
    let open = File::options()
        .create(true)
        .truncate(false)
        .read(true)
        .write(true)
        .open(path);
    let file = open.map_err(at(path, "open the lock file"))?;
    let locked = if shared {
        file.try_lock_shared()
    } else {
        file.try_lock()
    };
    match locked {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(Error::Locked { path: path.into() }),
        Err(TryLockError::Error(source)) => Err(at(path, "lock")(source)),
    }
}

/// Locks a folder by its [`LOCK_FILE`], which is made if need be and stays; the lock ends with the returned file, or with the process.
///
/// # Errors
/// [`Error::Locked`] while another process, or another call in this one, has it; [`Error::Io`].
pub fn lock_folder(folder: &Path) -> Result<File, Error> {
    lock(&folder.join(LOCK_FILE), false)
}

/// Reads a file for its size \[bytes\] and SHA-256 \[hexadecimal\].
///
/// # Errors
/// [`Error::Io`].
pub fn size_and_sha256(path: &Path) -> Result<(u64, String), Error> {
    let digest = || -> io::Result<(u64, String)> {
        let mut file = File::open(path)?;
        let (mut hash, mut size, mut bytes) = (Sha256::new(), 0, vec![0; 1 << 20]);
        while let n @ 1.. = file.read(&mut bytes)? {
            hash.update(&bytes[..n]);
            size += n as u64;
        }
        Ok((size, hex(hash)))
    };
    digest().map_err(at(path, "read"))
}

/// Computes the SHA-256 of bytes in memory, in hexadecimal.
///
/// ```
/// assert!(aps_data::sha256_of(b"abc").starts_with("ba7816bf8f01cfea414140de5dae2223"));
/// ```
pub fn sha256_of(bytes: &[u8]) -> String {
    hex(Sha256::new_with_prefix(bytes))
}

fn hex(hash: Sha256) -> String {
    let digits = hash.finalize();
    digits.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_what_is_no_file_is_refused() {
        let root = tempfile::tempdir().unwrap();
        let [target, link] = ["target", "link"].map(|name| root.path().join(name));
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink("target", &link).unwrap();
        replace_file(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&target).unwrap(), "new");
        let [nothing, circle] = ["nothing", "circle"].map(|name| root.path().join(name));
        std::os::unix::fs::symlink("not there yet", &nothing).unwrap();
        replace_file(&nothing, b"new").unwrap();
        assert_eq!(
            fs::read_to_string(root.path().join("not there yet")).unwrap(),
            "new"
        );
        std::os::unix::fs::symlink("circle", &circle).unwrap();
        assert!(PartialFile::create(&circle).is_err());
        // Nothing is made there, so that nothing could be lost.
        let refused = PartialFile::create(Path::new("/dev/null")).unwrap_err();
        let told = std::error::Error::source(&refused).unwrap().to_string();
        assert!(told.contains("no file"), "{told}");
        assert!(PartialFile::create(root.path()).is_err());
    }

    #[test]
    fn a_file_that_is_given_up_leaves_the_old_one() {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("file");
        fs::write(&target, "old").unwrap();
        let (partial, mut file) = PartialFile::create(&target).unwrap();
        file.write_all(b"half of the ne").unwrap();
        assert_eq!(fs::read_to_string(&target).unwrap(), "old");
        drop((file, partial));
        let read = || {
            (
                fs::read_to_string(&target).unwrap(),
                names_in(root.path()).unwrap(),
            )
        };
        assert_eq!(read(), ("old".into(), vec!["file".into()]));
        let (partial, mut file) = PartialFile::create(&target).unwrap();
        file.write_all(b"new").unwrap();
        partial.complete(file).unwrap();
        assert_eq!(read(), ("new".into(), vec!["file".into()]));
        let nowhere = root.path().join("nowhere/file");
        assert!(
            PartialFile::create(&nowhere)
                .unwrap_err()
                .to_string()
                .contains("nowhere")
        );
    }
}
