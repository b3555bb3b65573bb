//! Folders of maps and data sets, for tests of all kinds.

#[path = "../files.rs"]
mod files;
#[path = "../houses.rs"]
mod houses;

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use aps_data::Dataset;
use tempfile::TempDir;

pub use files::files;
pub use houses::map;

use crate::succeed;

/// Maps and data sets of a test; in memory where the system has a place for that, so that syncing costs nothing.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        let in_memory = tempfile::tempdir_in("/dev/shm");
        Folder(in_memory.or_else(|_| tempfile::tempdir()).unwrap())
    }

    /// A folder with so many maps in it; the second is theirs.
    pub fn with_maps(count: u32) -> (Self, String) {
        let folder = Self::new();
        let maps = folder.maps(count);
        (folder, maps)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn arg(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    /// Makes a folder of RadioMapSeer files, `count` maps of a few houses each.
    pub fn maps(&self, count: u32) -> String {
        fs::create_dir_all(self.path("maps")).unwrap();
        for id in 0..count {
            fs::write(self.path(&format!("maps/{id}.json")), map(id)).unwrap();
        }
        self.arg("maps")
    }

    /// Makes a data set of these settings; returns what was said.
    #[track_caller]
    pub fn make(&self, out: &str, settings: &[&str]) -> String {
        let settings = settings.join(" ");
        succeed(&format!("dataset {settings} --out {}", self.arg(out)))
    }

    /// Fails naming the files in which two data sets differ.
    #[track_caller]
    pub fn assert_same(&self, expected: &str, found: &str) {
        assert_same(&files(&self.path(expected)), &files(&self.path(found)));
    }
}

/// Number of the set pixels of all images of a data set.
pub fn set_pixels(dataset: &Dataset) -> usize {
    let maps = dataset.manifest().maps.iter();
    let set = maps.map(|map| {
        let image = dataset.map(map.id).unwrap().buildings;
        image.pixels().iter().filter(|&&pixel| pixel == 1).count()
    });
    set.sum()
}

/// Fails naming the files that differ, not showing them.
#[track_caller]
pub fn assert_same(expected: &BTreeMap<String, Vec<u8>>, found: &BTreeMap<String, Vec<u8>>) {
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(expected), names(found));
    let differ = |name: &&String| expected[*name] != found[*name];
    let differing: Vec<&String> = expected.keys().filter(differ).collect();
    assert!(differing.is_empty(), "{differing:?}");
}
