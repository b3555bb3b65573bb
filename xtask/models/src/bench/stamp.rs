//! Stamps parts of a benchmark with their settings: a part is reused with the same settings and made anew with others.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest as _, Sha256};
use xtask::note;

/// Raised when a part made by an earlier version can no longer be used.
const VERSION: u32 = 2;

/// Name of the file in the folder of a part.
const FILE: &str = "stamp.json";

/// The folder of a part: data set, trained model, scores.
#[derive(Debug)]
pub struct Part {
    folder: PathBuf,
    hash: String,
    settings: Value,
}

/// State of the folder of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Nothing that could be used: the folder is empty now.
    New,
    /// A beginning made with the same settings.
    Begun,
    /// The whole part, made with the same settings.
    Finished,
}

#[derive(Debug, Serialize, Deserialize)]
struct Stamp {
    hash: String,
    is_finished: bool,
    settings: Value,
    /// Sizes of the files of a finished part \[bytes\], by their names below its folder, but for those that nothing reads again.
    #[serde(default)]
    files: BTreeMap<PathBuf, u64>,
}

impl Part {
    /// A part that `settings` decide.
    pub fn new(folder: PathBuf, settings: Value) -> Self {
        Self {
            hash: hash(&settings),
            folder,
            settings,
        }
    }

    /// The folder of the part.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The hash of its settings, for the settings of parts that are made of it.
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// The folder's stamp, if it is of these settings.
    fn stamp(&self) -> Option<Stamp> {
        let text = fs::read_to_string(self.folder.join(FILE)).ok()?;
        let stamp: Stamp = serde_json::from_str(&text).ok()?;
        (stamp.hash == self.hash).then_some(stamp)
    }

    /// Opens the folder; removes its content unless that was made with these settings, or always if `fresh`.
    pub fn open(&self, fresh: bool) -> Result<State> {
        let place = || format!("folder '{}'", self.folder.display());
        if let Some(stamp) = self.stamp().filter(|_| !fresh) {
            if !stamp.is_finished {
                return Ok(State::Begun);
            }
            let Some(damaged) = self.damaged(&stamp) else {
                return Ok(State::Finished);
            };
            let damaged = self.folder.join(damaged);
            note!("'{}' is gone or was changed: made again", damaged.display());
        }
        if self.folder.exists() {
            fs::remove_dir_all(&self.folder).with_context(place)?;
        }
        fs::create_dir_all(&self.folder).with_context(place)?;
        self.write(false)?;
        Ok(State::New)
    }

    /// A file that is not as it was when the part was finished.
    fn damaged(&self, stamp: &Stamp) -> Option<PathBuf> {
        let is_same = |name: &Path, size| {
            let found = fs::metadata(self.folder.join(name));
            found.is_ok_and(|found| found.len() == size)
        };
        let mut files = stamp.files.iter();
        let other = files.find(|&(name, &size)| !is_same(name, size));
        other.map(|(name, _)| name.clone())
    }

    /// Marks the part as finished: no file in its folder changes after that.
    pub fn finish(&self) -> Result<()> {
        self.write(true)
    }

    fn write(&self, is_finished: bool) -> Result<()> {
        let mut files = BTreeMap::new();
        if is_finished {
            let place = || format!("folder '{}'", self.folder.display());
            files_below(&self.folder, Path::new(""), &mut files).with_context(place)?;
        }
        write_json(
            &self.folder.join(FILE),
            &Stamp {
                hash: self.hash.clone(),
                is_finished,
                settings: self.settings.clone(),
                files,
            },
        )
    }
}

/// Files of a training that nothing reads when it is finished: whoever removes its checkpoint loses nothing.
fn is_read_again(name: &Path) -> bool {
    let is_log = name.extension().is_some_and(|ending| ending == "csv");
    !is_log
        && !name.ends_with("last.safetensors")
        && !name.ends_with(aps_data::LOCK_FILE)
        && name != Path::new(FILE)
}

/// Collects the sizes of the files in a folder that are read again, by their names below `root`.
fn files_below(root: &Path, folder: &Path, files: &mut BTreeMap<PathBuf, u64>) -> io::Result<()> {
    for entry in fs::read_dir(root.join(folder))? {
        let entry = entry?;
        let (name, found) = (folder.join(entry.file_name()), entry.metadata()?);
        if found.is_dir() {
            files_below(root, &name, files)?;
        } else if is_read_again(&name) {
            files.insert(name, found.len());
        }
    }
    Ok(())
}

/// SHA-256 of JSON with its keys in order, in hexadecimal digits.
fn hash(settings: &Value) -> String {
    hex(Sha256::new_with_prefix(format!("{VERSION} {settings}")))
}

/// SHA-256 of all bytes, in hexadecimal digits.
pub fn digest(mut bytes: impl io::Read) -> io::Result<String> {
    let mut digest = Sha256::new();
    let mut block = vec![0; 1 << 16];
    loop {
        match bytes.read(&mut block)? {
            0 => return Ok(hex(digest)),
            read => digest.update(&block[..read]),
        }
    }
}

fn hex(digest: Sha256) -> String {
    let bytes = digest.finalize();
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Writes a value as JSON, whole or not at all.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_string_pretty(value)? + "\n";
    Ok(aps_data::replace_file(path, text.as_bytes())?)
}

/// Reads a value from JSON.
pub fn read_json<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T> {
    let place = || format!("'{}'", path.display());
    let text = fs::read_to_string(path).with_context(place)?;
    serde_json::from_str(&text).with_context(place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn part_is_reused_with_the_same_settings_alone() {
        let root = tempfile::tempdir().unwrap();
        let part = |settings| Part::new(root.path().join("part"), settings);
        let one = part(json!({ "seed": 1, "epochs": 2 }));
        assert_eq!(one.open(false).unwrap(), State::New);
        fs::write(one.folder().join("file"), "kept").unwrap();
        assert_eq!(one.open(false).unwrap(), State::Begun);
        one.finish().unwrap();
        let same = part(json!({ "epochs": 2, "seed": 1 }));
        assert_eq!(same.open(false).unwrap(), State::Finished);
        assert!(same.folder().join("file").is_file());
        // A file that is cut short is not what was made.
        fs::write(one.folder().join("file"), "kep").unwrap();
        assert_eq!(same.open(false).unwrap(), State::New);
        // One that is gone neither, but for what nothing reads again.
        for name in ["file", "last.safetensors"] {
            fs::write(one.folder().join(name), "kept").unwrap();
        }
        one.finish().unwrap();
        fs::remove_file(one.folder().join("last.safetensors")).unwrap();
        assert_eq!(same.open(false).unwrap(), State::Finished);
        fs::remove_file(one.folder().join("file")).unwrap();
        assert_eq!(same.open(false).unwrap(), State::New);
        one.finish().unwrap();
        let other = part(json!({ "seed": 2, "epochs": 2 }));
        assert_eq!(other.open(false).unwrap(), State::New);
        assert!(!other.folder().join("file").exists());
    }

    #[test]
    fn fresh_part_forgets_what_was_finished() {
        let root = tempfile::tempdir().unwrap();
        let part = Part::new(root.path().join("part"), json!(1));
        part.open(false).unwrap();
        part.finish().unwrap();
        assert_eq!(part.open(true).unwrap(), State::New);
        assert_eq!(part.open(false).unwrap(), State::Begun);
    }
}
