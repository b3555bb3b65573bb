//! Parts of a benchmark, each with a stamp: a part is used again with the same settings and made anew with others.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

use aps_data::sha256_of;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::{Error, Result};
use crate::files::write_json;
use crate::watch::{Event, Watch};

/// Raised when a part made by an earlier version can no longer be used.
const VERSION: u32 = 4;

/// Name of the file in the folder of a part.
const FILE: &str = "stamp.json";

/// The folder of a part: data set, trained model, scores.
#[derive(Debug)]
pub struct Part {
    /// The folder of the part.
    pub folder: PathBuf,
    /// The hash of its settings, for the settings of parts that are made of it.
    pub hash: String,
    settings: Value,
}

/// State of the folder of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Nothing usable is stored.
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
    /// Sizes of the files of a finished part \[bytes\], by their names in its folder: only of files that a later run reads.
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

    /// Reads the stamp in the folder, which may be of other settings.
    fn read(&self) -> Option<Stamp> {
        let text = fs::read_to_string(self.folder.join(FILE)).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Tells if the folder holds a finished part made with other settings.
    pub fn is_of_others(&self) -> bool {
        let is_other = |stamp: Stamp| stamp.is_finished && stamp.hash != self.hash;
        self.read().is_some_and(is_other)
    }

    /// Opens the folder; removes its content unless that was made with these settings, or always if `fresh`.
    pub fn open(&self, fresh: bool, watch: Watch<'_>) -> Result<State> {
        let place = || Error::file("folder", &self.folder);
        let is_own = |stamp: &Stamp| !fresh && stamp.hash == self.hash;
        if let Some(stamp) = self.read().filter(is_own) {
            if !stamp.is_finished {
                return Ok(State::Begun);
            }
            let Some(damaged) = self.damaged(&stamp) else {
                return Ok(State::Finished);
            };
            watch.tell(Event::Damaged(&self.folder.join(damaged)));
        }
        if self.folder.exists() {
            fs::remove_dir_all(&self.folder).map_err(place())?;
        }
        fs::create_dir_all(&self.folder).map_err(place())?;
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
            files_below(&self.folder, Path::new(""), &mut files)
                .map_err(Error::file("folder", &self.folder))?;
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

/// Tells if a later run reads a file. Of a finished training it reads no log and no checkpoint: these may be removed.
fn is_read_again(name: &Path) -> bool {
    let is_log = name.extension().is_some_and(|ending| ending == "csv");
    !is_log
        && !name.ends_with("last.safetensors")
        && !name.ends_with(aps_data::LOCK_FILE)
        && name != Path::new(FILE)
}

/// Collects the sizes of the files in a folder that a later run reads, by their names below `root`.
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
    sha256_of(format!("{VERSION} {settings}").as_bytes())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn open(part: &Part, fresh: bool) -> State {
        part.open(fresh, Watch::default()).unwrap()
    }

    #[test]
    fn part_is_reused_with_the_same_settings_alone() {
        let root = tempfile::tempdir().unwrap();
        let part = |settings| Part::new(root.path().join("part"), settings);
        let one = part(json!({ "seed": 1, "epochs": 2 }));
        assert_eq!(open(&one, false), State::New);
        fs::write(one.folder.join("file"), "kept").unwrap();
        assert_eq!(open(&one, false), State::Begun);
        one.finish().unwrap();
        let same = part(json!({ "epochs": 2, "seed": 1 }));
        assert_eq!(open(&same, false), State::Finished);
        assert!(same.folder.join("file").is_file());
        // A file that is cut short is not what was made.
        fs::write(one.folder.join("file"), "kep").unwrap();
        assert_eq!(open(&same, false), State::New);
        // One that is gone neither, but for what nothing reads again.
        for name in ["file", "last.safetensors"] {
            fs::write(one.folder.join(name), "kept").unwrap();
        }
        one.finish().unwrap();
        fs::remove_file(one.folder.join("last.safetensors")).unwrap();
        assert_eq!(open(&same, false), State::Finished);
        fs::remove_file(one.folder.join("file")).unwrap();
        assert_eq!(open(&same, false), State::New);
        one.finish().unwrap();
        let other = part(json!({ "seed": 2, "epochs": 2 }));
        assert!(other.is_of_others() && !one.is_of_others());
        assert_eq!(open(&other, false), State::New);
        assert!(!other.folder.join("file").exists());
    }

    #[test]
    fn fresh_part_forgets_what_was_finished() {
        let root = tempfile::tempdir().unwrap();
        let part = Part::new(root.path().join("part"), json!(1));
        open(&part, false);
        part.finish().unwrap();
        assert_eq!(open(&part, true), State::New);
        assert_eq!(open(&part, false), State::Begun);
    }
}
