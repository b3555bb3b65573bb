//! A data set as the files of the published data.

mod folder;
mod released;
pub(super) mod samples;
#[cfg(feature = "parquet")]
mod tables;

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::fs;
use std::path::Path;

use aps_data::released::LinkName;
use aps_data::{Dataset, Manifest, MapData, Part, lock_folder, replace_unsynced, sha256_of};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::ExchangeError;
use crate::control::{Control, Work};
use crate::error::{At, Place, Result};
use crate::maps::choose;
use crate::targets::{labelled_links, maps_of};
use folder::{create_folder, must_be_empty, remove_partial_files};

pub use folder::Exported;

/// Kept in the folder, so that one export is not continued by another.
pub(super) const RECORD_FILE: &str = "export.json";

/// Form of an export.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportLayout {
    /// `map_N/N_adps/{aps,pdp}/*.npy`: labels with the places of their maxima, half precision.
    Released,
    /// `samples/*.npz`: normalised labels with their condition images, as models train on them.
    Samples,
    /// `data/PART/map_N.parquet`: one row a link, labelled or not, with a card and a Croissant description for hubs of data
    /// sets. Labels of any protocol, as they are.
    #[cfg(feature = "parquet")]
    Parquet,
}

/// Export of a data set: one or two files a link.
#[derive(Debug, Clone)]
pub struct Export {
    /// Form of the files.
    pub layout: ExportLayout,
    /// Part of the split that is exported; otherwise all maps.
    pub part: Option<Part>,
    /// Maps that are exported, ascending; otherwise all.
    pub maps: Option<Vec<u32>>,
    /// Most links in all.
    pub limit: Option<usize>,
    /// Labels of another protocol than the released one are exported as they are.
    pub any_protocol: bool,
    /// Places of maxima are 0 where neither they nor the paths are stored.
    pub zero_places: bool,
}

impl Export {
    /// An export of all links in one form.
    pub fn new(layout: ExportLayout) -> Self {
        Self {
            layout,
            part: None,
            maps: None,
            limit: None,
            any_protocol: false,
            zero_places: false,
        }
    }

    /// Writes the files into the folder `out`, which must be empty or of the same export, but for hidden files. Files that are there
    /// are kept: the same call continues what was interrupted.
    ///
    /// # Errors
    /// A data set that lacks what the form needs, a folder with something else or into which another export writes, maps that are not
    /// there, a disk that fails, and cancellation.
    pub fn run(&self, dataset: &Dataset, out: &Path, control: &Control<'_>) -> Result<Exported> {
        self.check_protocol(dataset)?;
        let ids = self.map_ids(dataset)?;
        if self.layout == ExportLayout::Samples {
            samples::Samples::check(dataset)?;
        }
        create_folder(out)?;
        if !out.join(RECORD_FILE).exists() {
            // Before anything of ours lies in it.
            must_be_empty(out)?;
        }
        let _lock = lock_folder(out)?;
        self.record(dataset, out)?;
        #[cfg(feature = "parquet")]
        if self.layout == ExportLayout::Parquet {
            return tables::export(self.limit, &ids, dataset, out, control);
        }
        control.progress.begin(Work {
            units: self.links(dataset, &ids),
            name: "links",
            finished_maps: 0,
            maps: ids.len(),
        });
        let mut bytes = 0;
        let mut left = self.limit.unwrap_or(usize::MAX);
        let mut names = Vec::new();
        for id in ids {
            if left == 0 {
                break;
            }
            control.progress.map(id);
            let map = dataset.map(id)?;
            let mut links = names_of(&map)?;
            links.truncate(left);
            left -= links.len();
            bytes += match self.layout {
                ExportLayout::Released => {
                    let exporter = released::Released::new(dataset, &map, self.zero_places)?;
                    exporter.create_folders(id, out)?;
                    write_links(id, &links, control, |buffers, link, name| {
                        exporter.write(link, name, out, buffers)
                    })?
                }
                #[cfg(feature = "parquet")]
                ExportLayout::Parquet => unreachable!("tables are written above"),
                ExportLayout::Samples => {
                    let exporter = samples::Samples::new(&map);
                    exporter.write_buildings(out)?;
                    write_links(id, &links, control, |&mut (), link, name| {
                        exporter.write(link, name, out)
                    })?
                }
            };
            names.extend(links.into_iter().map(|(_, name)| name));
        }
        if self.layout == ExportLayout::Samples {
            samples::write_table(&names, out)?;
        }
        let links = names.len();
        Ok(Exported { links, bytes })
    }

    fn check_protocol(&self, dataset: &Dataset) -> Result<(), ExchangeError> {
        let found = dataset.manifest().configuration["label"]["protocol"].as_str();
        match self.takes_any_protocol() || found == Some("released") {
            true => Ok(()),
            false => Err(ExchangeError::Protocol(found.map(Into::into))),
        }
    }

    fn takes_any_protocol(&self) -> bool {
        #[cfg(feature = "parquet")]
        if self.layout == ExportLayout::Parquet {
            return true;
        }
        self.any_protocol
    }

    fn map_ids(&self, dataset: &Dataset) -> Result<Vec<u32>> {
        let manifest = dataset.manifest();
        let available = match self.part {
            None => manifest.maps.iter().map(|map| map.id).collect(),
            Some(part) => maps_of(dataset, part)?.to_vec(),
        };
        match &self.maps {
            Some(chosen) => Ok(choose(&available, chosen)?),
            None => Ok(available),
        }
    }

    fn links(&self, dataset: &Dataset, ids: &[u32]) -> u64 {
        let valid = labelled_links(dataset, ids);
        valid.min(self.limit.unwrap_or(usize::MAX)) as u64
    }

    /// The form as it is noted.
    fn layout(&self) -> Value {
        match self.layout {
            ExportLayout::Released => json!("released"),
            // With the choice of links, for there are files about all of them. What the choice comes to may grow.
            ExportLayout::Samples => json!({ "samples": self.choice(), "limit": self.limit }),
            #[cfg(feature = "parquet")]
            ExportLayout::Parquet => json!({ "parquet": self.choice() }),
        }
    }

    fn choice(&self) -> Value {
        let maps = self.maps.as_ref();
        let maps = maps.map(|maps| maps.iter().collect::<BTreeSet<_>>());
        json!({ "maps": maps, "part": self.part.map(Part::name) })
    }

    /// Notes what is exported, or refuses to go on with another export.
    fn record(&self, dataset: &Dataset, out: &Path) -> Result<()> {
        let (manifest, path) = (dataset.manifest(), out.join(RECORD_FILE));
        let found: Option<Value> = match fs::read(&path) {
            Ok(bytes) => Some(serde_json::from_slice(&bytes).unwrap_or_default()),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => None,
            Err(error) => return Err(error).at_file(Place::Reading, &path),
        };
        let own = serde_json::to_vec(&json!({
            "layout": self.layout(),
            "seed": manifest.seed,
            "stored": manifest.layout,
            "configuration": manifest.configuration,
            "source": source(manifest)?,
        }))?;
        // Through text, as the stored one went. The data set may have more maps by now.
        let mut own: Value = serde_json::from_slice(&own)?;
        if let Some(found) = &found {
            let is_there = |(map, files): (&String, &Value)| own["source"][map] == *files;
            let noted = found["source"].as_object();
            let is_source = noted.is_some_and(|noted| noted.iter().all(is_there));
            let is_same = |name: &&str| found[*name] == own[*name];
            let settings = ["layout", "seed", "stored", "configuration"];
            if !is_source || !settings.iter().all(is_same) {
                return Err(ExchangeError::OtherExport(path).into());
            }
            remove_partial_files(out)?;
        }
        own["maps"] = self.maps_by_part(dataset, found.as_ref(), out)?;
        match found.as_ref() == Some(&own) {
            true => Ok(()),
            false => Ok(replace_unsynced(&path, &serde_json::to_vec_pretty(&own)?)?),
        }
    }

    /// The maps that were exported as those of a part, by part, these among them. A larger data set may be split otherwise: files of
    /// a map that has left its part must not stay.
    fn maps_by_part(&self, dataset: &Dataset, found: Option<&Value>, out: &Path) -> Result<Value> {
        let noted = found.map_or(&Value::Null, |found| &found["maps"]);
        let mut by_part: BTreeMap<String, BTreeSet<u32>> =
            serde_json::from_value(noted.clone()).unwrap_or_default();
        if let Some(part) = self.part {
            let maps = by_part.entry(part.name().into()).or_default();
            let of_part = dataset.manifest().split.maps(part);
            if let Some(&map) = maps.iter().find(|id| !of_part.contains(id)) {
                let folder = out.into();
                return Err(ExchangeError::LeftPart { map, folder }.into());
            }
            maps.extend(self.map_ids(dataset)?);
        }
        Ok(json!(by_part))
    }
}

/// The maps of a data set, each with the checksum of its list of files.
fn source(manifest: &Manifest) -> Result<BTreeMap<u32, String>> {
    let maps = manifest.maps.iter();
    let maps = maps.map(|map| Ok((map.id, sha256_of(&serde_json::to_vec(&map.files)?))));
    maps.collect()
}

/// Writes the files of some links of a map on all threads, each with buffers of its own; returns the bytes written.
fn write_links<B: Default>(
    map: u32,
    links: &[(usize, LinkName)],
    control: &Control<'_>,
    write: impl Fn(&mut B, usize, &LinkName) -> Result<u64> + Sync,
) -> Result<u64> {
    let links = links.par_iter();
    let bytes = links.map_init(B::default, |buffers, (link, name)| {
        control.check()?;
        let bytes = write(buffers, *link, name);
        control.progress.advance(1);
        bytes.at(Place::Link(*link)).at(Place::Map(map))
    });
    bytes.try_reduce(|| 0, |a, b| Ok(a + b))
}

/// The links with a label and the names of their files, which must differ.
fn names_of(map: &MapData) -> Result<Vec<(usize, LinkName)>, ExchangeError> {
    let mut seen = HashSet::new();
    let named = map.valid_links().map(|link| {
        let ((tx_m, rx_m), map) = (map.ends_m(link), map.id);
        let name = LinkName::of(map, tx_m, rx_m).ok_or(ExchangeError::TooFar {
            map,
            link,
            tx_m,
            rx_m,
        })?;
        match seen.insert(name) {
            true => Ok((link, name)),
            false => Err(ExchangeError::SameName { map, link, name }),
        }
    });
    named.collect()
}

#[cfg(test)]
mod tests {
    use aps_data::is_partial;

    use super::*;
    use crate::synthetic;

    #[test]
    fn an_export_is_continued_by_its_data_set_alone_and_without_what_a_killed_one_left() {
        let root = tempfile::tempdir().unwrap();
        let out = root.path().join("out");
        let [data, other] = [[0, 1], [2, 3]].map(|maps| {
            let folder = root.path().join(format!("{maps:?}"));
            synthetic::made(&synthetic::plan(4, 1, 2), &folder, &maps)
        });
        let export = Export::new(ExportLayout::Samples);
        let run = |dataset| export.run(dataset, &out, &Control::default());
        run(&data).unwrap();
        let mut part = Export::new(ExportLayout::Samples);
        part.part = Some(Part::Test);
        let of_part = part.run(&data, &out, &Control::default());
        for told in [run(&other), of_part] {
            let told = told.unwrap_err().chain();
            assert!(told.contains("is of another export"), "{told}");
        }
        // A map that the first lacks may be added, another of the same number may not.
        let folder = root.path().join("more");
        let more = synthetic::made(&synthetic::plan(4, 1, 2), &folder, &[0, 1, 2]);
        assert_eq!(run(&more).unwrap().links, 6);
        assert!(run(&data).is_err());
        let data = &more;

        let samples = out.join("samples");
        let (partial, file) = aps_data::PartialFile::create(&samples.join("x.npz")).unwrap();
        let left = fs::read_dir(&samples)
            .unwrap()
            .map(|entry| entry.unwrap().path());
        let left = left.filter(|path| is_partial(path.file_name().unwrap()));
        let left: Vec<_> = left.collect();
        assert_eq!(left.len(), 1);
        drop((partial, file));
        fs::write(&left[0], "half").unwrap();
        fs::write(samples.join(".hidden"), "own").unwrap();
        let lock = lock_folder(&out).unwrap();
        let told = run(data).unwrap_err().chain();
        assert!(told.contains("is locked") && left[0].exists(), "{told}");
        drop(lock);
        run(data).unwrap();
        assert!(!left[0].exists() && samples.join(".hidden").exists());

        // A map that has left the part.
        let of_test = Export {
            part: Some(Part::Test),
            ..Export::new(ExportLayout::Samples)
        };
        let out_of_test = root.path().join("test");
        let exported = |data| of_test.run(data, &out_of_test, &Control::default());
        exported(data).unwrap();
        exported(data).unwrap();
        let grown = synthetic::made(&synthetic::plan(4, 1, 2), &folder, &[0, 1, 2, 3]);
        assert_ne!(grown.manifest().split.test, data.manifest().split.test);
        let told = exported(&grown).unwrap_err().chain();
        assert!(told.contains("of another part now"), "{told}");
        // Published files of several parts and choices lie side by side.
        let side_by_side = root.path().join("side-by-side");
        for (part, maps) in [
            (Some(Part::Train), None),
            (Some(Part::Test), None),
            (None, Some(vec![0])),
            (None, None),
        ] {
            let export = Export {
                part,
                maps,
                zero_places: true,
                ..Export::new(ExportLayout::Released)
            };
            export
                .run(data, &side_by_side, &Control::default())
                .unwrap();
        }

        // A record of no source, and one that tells none.
        let record = out.join(RECORD_FILE);
        let mut told: Value = serde_json::from_slice(&fs::read(&record).unwrap()).unwrap();
        told["source"] = Value::Null;
        fs::write(&record, told.to_string()).unwrap();
        assert!(run(data).is_err());
        told.as_object_mut().unwrap().remove("source").unwrap();
        fs::write(&record, told.to_string()).unwrap();
        assert!(run(data).is_err());
        for foreign in ["[]", "3", "\"x\"", "{}"] {
            fs::write(&record, foreign).unwrap();
            assert!(run(data).is_err(), "{foreign}");
        }
    }
}
