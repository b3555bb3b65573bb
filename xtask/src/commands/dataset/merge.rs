//! `cargo xtask dataset merge`: joins shards into the data set that one run would have made.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use aps_data::{DatasetWriter, Plan, Split, Survey};

use crate::args::Shard;
use crate::command_line;
use crate::progress;
use crate::say;

/// Join what shards made into what one run would have made, byte for byte.
///
/// The data set holds every map that any of the folders holds or was to hold.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folders of the shards; none if all of them worked in the folder given by --out.
    folders: Vec<PathBuf>,
    /// Folder of the data set; an unfinished one is continued.
    #[arg(long)]
    out: PathBuf,
}

/// A folder with shards, and its contents.
struct Part {
    folder: PathBuf,
    survey: Survey,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let parts = self.parts()?;
        let Some(config) = parts.iter().find_map(|part| part.survey.config.clone()) else {
            bail!("no map is finished in {}", names(&parts));
        };
        let sources = where_maps_are(&parts);
        must_be_all_there(&parts, &sources)?;
        let seed = config.seed;
        let writer = DatasetWriter::open(&self.out, config)
            .with_context(|| format!("data set '{}'", self.out.display()))?;
        let mut todo: Vec<(&u32, &&Part)> = sources.iter().collect();
        todo.retain(|(id, _)| !writer.has_map(**id));
        if !todo.is_empty() {
            writer.set_plan(&Plan {
                maps: sources.keys().copied().collect(),
                shards: None,
                command: command_line::own_without(&["--out"]),
            })?;
        }
        let progress = progress::bar(todo.len() as u64, "maps");
        for (&id, part) in todo {
            writer.adopt_map(&part.folder, id).with_context(|| {
                format!("cannot take map {id} from '{}'", part.folder.display())
            })?;
            progress.inc(1);
        }
        progress.finish_and_clear();
        let ids = writer.map_ids();
        let totals = writer.finish(&Split::of_maps(ids, seed))?.totals;
        say!(
            "{} maps, {} links, {} bytes in data set '{}'",
            totals.maps,
            totals.links,
            totals.bytes,
            self.out.display()
        )?;
        Ok(())
    }

    /// The folders given, and the one of the result if something is there.
    fn parts(&self) -> Result<Vec<Part>> {
        let mut parts = Vec::new();
        for folder in &self.folders {
            parts.push(Part {
                survey: Survey::of(folder)?,
                folder: folder.clone(),
            });
        }
        let is_new =
            |out: &Path| !out.exists() || out.read_dir().is_ok_and(|mut e| e.next().is_none());
        match Survey::of(&self.out) {
            // A lock file alone is left where a merge was refused.
            Err(_) if is_new(&self.out) || !parts.is_empty() => {}
            survey => parts.push(Part {
                survey: survey?,
                folder: self.out.clone(),
            }),
        }
        ensure!(!parts.is_empty(), "give the folders of the shards");
        Ok(parts)
    }
}

fn names(parts: &[Part]) -> String {
    let name = |part: &Part| format!("'{}'", part.folder.display());
    parts.iter().map(name).collect::<Vec<_>>().join(", ")
}

/// Each whole map and one of the folders that have it.
fn where_maps_are(parts: &[Part]) -> BTreeMap<u32, &Part> {
    let of_part = |part| Part::ids(part).map(move |id| (id, part));
    parts.iter().rev().flat_map(of_part).collect()
}

impl Part {
    fn ids(&self) -> impl Iterator<Item = u32> {
        self.survey.maps.iter().map(|map| map.id)
    }

    fn holds(&self, shard: Shard) -> bool {
        self.ids().any(|id| shard.access().covers(id))
    }

    /// Returns true when maps of several shards are here.
    fn is_shared(&self, count: u32) -> bool {
        let shards = (1..=count).map(|number| Shard { number, count });
        shards.filter(|&shard| self.holds(shard)).count() > 1
    }

    /// The commands that make the given maps of this part's plan.
    fn commands(&self, plan: &Plan, missing: &[u32]) -> Vec<String> {
        let out = |folder: PathBuf| ["--out".into(), folder.display().to_string()];
        let Some(count) = plan.shards else {
            let command = plan.command.iter().cloned().chain(out(self.folder.clone()));
            return vec![command_line::shown(command)];
        };
        let shards = (1..=count).map(|number| Shard { number, count });
        let lacking = shards.filter(|shard| missing.iter().any(|&id| shard.access().covers(id)));
        lacking
            .map(|shard| {
                // A folder with maps of this shard, or of several, is where it was at work.
                let folder = match self.holds(shard) || self.is_shared(count) {
                    true => self.folder.clone(),
                    false => {
                        let mut name = self.folder.as_os_str().to_owned();
                        name.push(format!("-{}-of-{count}", shard.number));
                        name.into()
                    }
                };
                let of_shard = ["--shard".into(), shard.to_string()];
                let command = plan.command.iter().cloned().chain(of_shard);
                command_line::shown(command.chain(out(folder)))
            })
            .collect()
    }
}

/// Refuses to make less than what was planned.
fn must_be_all_there(parts: &[Part], there: &BTreeMap<u32, &Part>) -> Result<()> {
    let is_missing = |id: &u32| !there.contains_key(id);
    let mut missing: Vec<u32> = parts
        .iter()
        .flat_map(|part| part.survey.missing())
        .collect();
    missing.retain(is_missing);
    missing.sort_unstable();
    missing.dedup();
    if missing.is_empty() {
        return Ok(());
    }
    // Each missing map is asked for once, of the first folder whose plan names it.
    let mut left = missing.clone();
    let mut commands = Vec::new();
    for part in parts {
        let Some(plan) = &part.survey.plan else {
            continue;
        };
        let own: Vec<u32> = left
            .iter()
            .copied()
            .filter(|id| plan.maps.contains(id))
            .collect();
        left.retain(|id| !own.contains(id));
        if !own.is_empty() {
            commands.extend(part.commands(plan, &own));
        }
    }
    bail!(
        "maps {missing:?} are in none of {}; make them first:\n  {}",
        names(parts),
        commands.join("\n  ")
    )
}
