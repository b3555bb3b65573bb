//! Shards joined into the data set that one run would have made.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use aps_data::{Access, DatasetWriter, Plan, Survey, Totals};

use super::builder::or_kept;
use super::{MergeError, MissingPart};
use crate::control::{Control, Work};
use crate::error::{At, Place, Result};
use crate::maps::{self, ascending};
use crate::settings;

/// Joins the maps of some folders in the folder `out`, byte for byte as one run would have made them. Maps that it holds
/// already are kept. With no folders given, the shards are those that worked in `out`.
///
/// # Errors
/// [`MergeError`], folders that hold no data set or one of other settings, and a disk that fails.
pub fn merge(folders: &[PathBuf], out: &Path, control: &Control<'_>) -> Result<Totals> {
    let parts = parts(folders, out)?;
    let config = parts.iter().find_map(|part| part.survey.config.clone());
    let config = config.ok_or_else(|| MergeError::NoMap(names_of(&parts)))?;
    for part in &parts {
        // One whose maps are all in others too would not be looked at below.
        let mut own = part.survey.config.iter();
        own.try_for_each(|own| config.must_equal(own, &part.folder))?;
    }
    must_be_alike(&parts)?;
    // Each whole map and one of the folders that have it.
    let of_part = |part| Part::ids(part).map(move |id| (id, part));
    let sources: BTreeMap<u32, &Part> = parts.iter().rev().flat_map(of_part).collect();
    must_be_all_there(&parts, &sources, out)?;
    let seed = config.seed;
    let orientations = settings::scene_of(&config.configuration)?.orientations;
    let writer = DatasetWriter::open(out, config).at_file(Place::Dataset, out)?;
    let all = ascending(sources.keys().copied().chain(writer.map_ids()));
    let split = maps::split(&all, seed, orientations)?;
    let mut todo: Vec<(&u32, &&Part)> = sources.iter().collect();
    todo.retain(|(id, _)| !writer.has_map(**id));
    if !todo.is_empty() {
        writer.set_plan(&control.plan(sources.keys().copied().collect(), None))?;
    }
    control.progress.begin(Work {
        units: todo.len() as u64,
        name: "maps",
        finished_maps: sources.len() - todo.len(),
        maps: sources.len(),
    });
    for (&id, part) in todo {
        let taken = writer.adopt_map(&part.folder, id);
        let taken = taken.at(Place::MapFrom(id, part.folder.clone()));
        or_kept(taken, &writer, out, control)?;
        control.progress.advance(1);
    }
    Ok(writer.finish(&split)?.totals)
}

/// A folder with shards, and its contents.
struct Part {
    folder: PathBuf,
    survey: Survey,
}

/// The folders given, and the one of the result if something is there.
fn parts(folders: &[PathBuf], out: &Path) -> Result<Vec<Part>> {
    let part = |folder: &Path| -> Result<Part> {
        let survey = Survey::of(folder)?;
        let folder = folder.into();
        Ok(Part { folder, survey })
    };
    let mut parts: Vec<Part> = folders.iter().map(|f| part(f)).collect::<Result<_>>()?;
    let is_new = !out.exists() || out.read_dir().is_ok_and(|mut e| e.next().is_none());
    match part(out) {
        // A lock file alone is left where a merge was refused.
        Err(_) if is_new || !parts.is_empty() => {}
        part => parts.push(part?),
    }
    match parts.is_empty() {
        true => Err(MergeError::NoFolder.into()),
        false => Ok(parts),
    }
}

fn names_of(parts: &[Part]) -> Vec<PathBuf> {
    parts.iter().map(|part| part.folder.clone()).collect()
}

impl Part {
    fn ids(&self) -> impl Iterator<Item = u32> {
        self.survey.maps.iter().map(|map| map.id)
    }

    fn holds(&self, shard: Access) -> bool {
        self.ids().any(|id| shard.covers(id))
    }

    /// The runs that make the given maps of this part's plan, for a merge into `out`.
    fn missing(&self, plan: &Plan, missing: &[u32], out: &Path) -> Vec<MissingPart> {
        let part = |shard, folder| MissingPart {
            command: plan.command.clone(),
            shard,
            folder,
        };
        let Some(count) = plan.shards else {
            return vec![part(Access::Whole, self.folder.clone())];
        };
        let shard = |index| Access::Shard { index, count };
        // The merge looks into its own folder, whichever others it is given.
        let is_shared =
            self.folder == out || (0..count).filter(|&index| self.holds(shard(index))).count() > 1;
        let lacks = |&index: &u32| missing.iter().any(|&id| shard(index).covers(id));
        let run = |index| {
            // A folder with maps of this shard, or of several, is where it was at work.
            let mut folder = self.folder.clone().into_os_string();
            if !self.holds(shard(index)) && !is_shared {
                folder.push(format!("-{}-of-{count}", index + 1));
            }
            part(shard(index), folder.into())
        };
        (0..count).filter(lacks).map(run).collect()
    }
}

/// Refuses folders of which two hold different files of one map.
fn must_be_alike(parts: &[Part]) -> Result<(), MergeError> {
    let mut seen = BTreeMap::new();
    for part in parts {
        for map in &part.survey.maps {
            let (first, folder) = seen.entry(map.id).or_insert((map, &part.folder));
            if first.files != map.files {
                return Err(MergeError::Differ {
                    map: map.id,
                    folders: [part.folder.clone(), folder.to_path_buf()],
                });
            }
        }
    }
    Ok(())
}

/// Refuses to make less than what was planned.
fn must_be_all_there(
    parts: &[Part],
    there: &BTreeMap<u32, &Part>,
    out: &Path,
) -> Result<(), MergeError> {
    let missing = parts.iter().flat_map(|part| part.survey.missing());
    let maps = ascending(missing.filter(|id| !there.contains_key(id)));
    if maps.is_empty() {
        return Ok(());
    }
    // Each missing map is asked for once, of the first folder whose plan names it.
    let mut left = maps.clone();
    let mut runs = Vec::new();
    for part in parts {
        let Some(plan) = &part.survey.plan else {
            continue;
        };
        let is_own = |id: &u32| plan.maps.contains(id);
        let own: Vec<u32> = left.iter().copied().filter(is_own).collect();
        left.retain(|id| !own.contains(id));
        if !own.is_empty() {
            runs.extend(part.missing(plan, &own, out));
        }
    }
    Err(MergeError::Missing {
        maps,
        folders: names_of(parts),
        parts: runs,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;

    #[test]
    fn a_folder_of_other_settings_is_refused_though_its_maps_are_in_another() {
        let root = tempfile::tempdir().unwrap();
        let folders = ["first", "other"].map(|name| root.path().join(name));
        for (folder, frequency_hz) in folders.iter().zip([3.5e9, 28e9]) {
            let mut plan = synthetic::plan(1, 1, 2);
            plan.trace.frequency_hz = frequency_hz;
            plan.make(folder, &[0], &Control::default()).unwrap();
        }
        let out = root.path().join("out");
        let refused = merge(&folders, &out, &Control::default()).unwrap_err();
        let told = refused.chain();
        assert!(
            told.contains("frequency_hz") && told.contains("other"),
            "{told}"
        );
        merge(&folders[..1], &out, &Control::default()).unwrap();
    }

    #[test]
    fn a_map_that_two_folders_hold_otherwise_is_refused() {
        let root = tempfile::tempdir().unwrap();
        let folders = ["first", "other"].map(|name| root.path().join(name));
        for folder in &folders {
            synthetic::made(&synthetic::plan(2, 1, 2), folder, &[0, 1]);
        }
        let out = root.path().join("out");
        let alike = merge(&folders, &out, &Control::default());
        assert_eq!(alike.unwrap().maps, 2);
        for name in ["manifest.json", "map_0001/map.json"] {
            let path = folders[1].join(name);
            let text = std::fs::read_to_string(&path).unwrap();
            let at = text.rfind("\"sha256\": \"").unwrap() + 11;
            let digit = if &text[at..=at] == "0" { "1" } else { "0" };
            std::fs::write(&path, [&text[..at], digit, &text[at + 1..]].concat()).unwrap();
        }
        let told = merge(&folders, &root.path().join("new"), &Control::default());
        let told = told.unwrap_err().chain();
        assert!(
            told.contains("map 1 in") && told.contains("other"),
            "{told}"
        );
    }
}
