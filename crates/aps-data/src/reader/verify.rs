//! Checks of a whole data set: every byte and every value.

use std::path::Path;

use super::Dataset;
use crate::durable;
use crate::error::Error;
use crate::json;
use crate::manifest::{MANIFEST_FILE, MAP_FILE, MapEntry, MapManifest};

impl Dataset {
    /// Checks everything that can be checked without the maps' sources: every byte of every file
    /// against its checksum, and every value against its range. Returns all problems found.
    ///
    /// A single changed byte anywhere is found: in an array by its checksum, in a manifest because
    /// the data set has only one way to write it.
    pub fn verify(&self) -> Vec<Error> {
        let of_maps = self.manifest.maps.iter();
        let of_maps = of_maps.flat_map(|map| self.verify_map(map.id));
        self.verify_manifest().into_iter().chain(of_maps).collect()
    }

    /// The part of [`Dataset::verify`] that concerns no single map: the manifest, and maps in the
    /// folder that it does not name.
    pub fn verify_manifest(&self) -> Vec<Error> {
        let path = self.root.join(MANIFEST_FILE);
        let problem = "its bytes are not those that this program writes for what it says";
        let same = must_be(&path, &json::to_bytes(&self.manifest), problem.into());
        let mut problems = Vec::from_iter(same.err());
        match MapEntry::folders_in(&self.root) {
            Ok(mut folders) => {
                folders.retain(|(id, _)| self.entry(*id).is_err());
                let problem = "the manifest does not name this map";
                problems.extend(folders.into_iter().map(|(_, path)| Error::Damaged {
                    path,
                    problem: problem.into(),
                }));
            }
            Err(error) => problems.push(error),
        }
        problems
    }

    /// The part of [`Dataset::verify`] that concerns one map.
    pub fn verify_map(&self, id: u32) -> Vec<Error> {
        let map = match self.entry(id) {
            Ok(map) => map,
            Err(error) => return vec![error],
        };
        let problems = self.verify_bytes(map);
        // Values of damaged files would only repeat the news.
        match problems.is_empty() {
            true => self.verify_values(map),
            false => problems,
        }
    }

    fn verify_bytes(&self, map: &MapEntry) -> Vec<Error> {
        let folder = self.folder(map.id);
        let manifest = MapManifest {
            format_version: self.manifest.format_version,
            ..MapManifest::new(self.manifest.config(), map.clone())
        };
        let problem = format!("it and {MANIFEST_FILE} say different things");
        let same = must_be(&folder.join(MAP_FILE), &json::to_bytes(&manifest), problem);
        let mut problems = Vec::from_iter(same.err());
        for file in &map.files {
            let path = folder.join(&file.name);
            match durable::size_and_sha256(&path) {
                Ok((_, found)) if found == file.sha256 => {}
                Ok((_, found)) => problems.push(Error::Checksum {
                    path,
                    stored: file.sha256.clone(),
                    found,
                }),
                Err(error) => problems.push(error),
            }
        }
        problems.extend(self.foreign_files(map));
        problems
    }

    /// Files in the folder of a map that are not part of it.
    fn foreign_files(&self, map: &MapEntry) -> Vec<Error> {
        let folder = self.folder(map.id);
        let names = match durable::names_in(&folder) {
            Ok(names) => names,
            Err(error) => return vec![error],
        };
        let is_own = |name: &String| name == MAP_FILE || map.files.iter().any(|f| f.name == *name);
        let foreign = names.into_iter().filter(|name| !is_own(name));
        foreign
            .map(|name| Error::Damaged {
                path: folder.join(name),
                problem: "it is no part of the map".into(),
            })
            .collect()
    }

    fn verify_values(&self, map: &MapEntry) -> Vec<Error> {
        let id = map.id;
        let mut problems = Vec::new();
        match self.map(id) {
            Ok(data) if data.status_counts() != map.status => {
                problems
                    .push(self.damaged(id, "status.npy has other counts than the manifest".into()));
            }
            Ok(_) => {}
            Err(error) => problems.push(error),
        }
        if self.manifest.layout.pdp.is_some() {
            problems.extend(self.pdp(id).err());
        }
        if self.manifest.layout.paths {
            problems.extend(self.paths(id).err());
        }
        problems
    }
}

/// Compares a file with the only bytes it can have.
fn must_be(path: &Path, expected: &[u8], problem: String) -> Result<(), Error> {
    match json::read_bytes(path)? == expected {
        true => Ok(()),
        false => Err(Error::Damaged {
            path: path.into(),
            problem,
        }),
    }
}
