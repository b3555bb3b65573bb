//! `cargo xtask slurm`: a data set made by a cluster.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use map2aps::maps::{NamedMaps, ranges};

use super::dataset::Order;
use crate::cautions;
use crate::command_line;
use crate::{note, say};

mod scripts;

use scripts::{ARRAY, Job, MERGE, PROGRAM, SUBMIT};

/// Highest number of a task in an array where the cluster says nothing else: MaxArraySize is 1001.
const USUAL_LAST_TASK: u32 = 1000;

/// Options of this command that the tasks are not given, and their values.
const OWN_OPTIONS: [&str; 8] = [
    "--out",
    "--map-ids",
    "--nodes",
    "--tasks",
    "--cpus",
    "--retries",
    "--sbatch",
    "--scripts",
];

/// Make a data set on a Slurm cluster: a job array with a shard a task, and a job that joins and checks them.
///
/// Takes the options of `dataset` but --shard and --threads, which every task sets for itself. The folders of maps,
/// result and scripts must be reachable from all nodes by the same names. Given once more, the same command asks
/// only for the shards that still lack maps.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Most tasks at once, one a node.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    nodes: u32,
    /// Tasks in all, with a shard each [default: 4 a node, or one a map if that is less; at most 1000, which is what
    /// Slurm takes where MaxArraySize is not set].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    tasks: Option<u32>,
    /// Cores of a task, which may then share its node with others [default: the whole node].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    cpus: Option<u32>,
    /// Times that a task that fails or runs out of time goes back into the queue by itself.
    #[arg(long, default_value_t = 3)]
    retries: u32,
    /// An option for sbatch, for all jobs, like --sbatch=--partition=long; as many as are needed.
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    sbatch: Vec<String>,
    /// Folder of the scripts, the program and the logs [default: that of the data set, with -slurm at the end].
    #[arg(long, value_name = "DIR")]
    scripts: Option<PathBuf>,
    /// Submit the jobs; otherwise the scripts are written, and can be read first.
    #[arg(long)]
    submit: bool,
    #[command(flatten)]
    order: Order,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let here = std::env::current_dir().context("cannot tell the current folder")?;
        let folder = here.join(self.folder());
        let (plan, ids) = self.order.read()?;
        let out = &self.order.out;
        cautions::tell_carrier(&plan.trace);
        let count = plan.with_copies(&ids)?.len() as u32;
        let tasks = self.tasks.unwrap_or_else(|| {
            let by_nodes = self.nodes.saturating_mul(4).min(count);
            by_nodes.min(USUAL_LAST_TASK)
        });
        ensure!(
            tasks <= count,
            "{tasks} tasks for {count} maps: some would have nothing to do; give --tasks {count} or less"
        );
        // Settings that every task would refuse are refused here.
        let todo = plan.missing(out, &ids)?;
        let shards: BTreeSet<u32> = todo.iter().map(|id| id % tasks + 1).collect();
        let shards: Vec<u32> = shards.into_iter().collect();
        if let Some(&last) = shards.last()
            && last > USUAL_LAST_TASK
        {
            note!(
                "note: tasks up to number {last}; Slurm takes numbers up to {USUAL_LAST_TASK} where MaxArraySize is not \
                 set. {SUBMIT} asks the cluster, and submits nothing if this is too much"
            );
        }
        let job = Job {
            here: text(&here)?,
            folder: text(&folder)?,
            out: text(out)?,
            dataset: dataset_words(&ids),
            maps: maps_words(&self.order),
            tasks,
            shards: ranges(&shards),
            last_shard: shards.last().copied(),
            at_once: self.nodes,
            cpus: self.cpus,
            retries: self.retries,
            sbatch: &self.sbatch,
            command: command_line::shown(command_line::own_without(&[])),
        };
        fs::create_dir_all(folder.join("log"))
            .with_context(|| format!("cannot create '{}'", folder.display()))?;
        copy_program(&folder.join(PROGRAM))?;
        for (name, script) in [
            (ARRAY, job.array()),
            (MERGE, job.merge()),
            (SUBMIT, job.submit()),
        ] {
            aps_data::replace_unsynced(&folder.join(name), script.as_bytes())?;
        }
        let submit = folder.join(SUBMIT);
        say!(
            "{count} maps, {} links; {} of {tasks} tasks to do, {} at once",
            u64::from(count) * (plan.tx_per_map * plan.rx_per_map) as u64,
            shards.len(),
            self.nodes.min(shards.len() as u32),
        )?;
        if !self.submit {
            say!("to submit: bash {}", command_line::quoted(text(&submit)?))?;
            return Ok(());
        }
        let status = Command::new("bash").arg(&submit).status();
        let status = status.with_context(|| format!("cannot run '{}'", submit.display()))?;
        ensure!(status.success(), "'{}' failed: {status}", submit.display());
        Ok(())
    }

    /// Folder of the scripts.
    fn folder(&self) -> PathBuf {
        self.scripts.clone().unwrap_or_else(|| {
            let mut folder = self.order.out.clone().into_os_string();
            folder.push("-slurm");
            folder.into()
        })
    }
}

/// A path as it may stand in a script.
fn text(path: &Path) -> Result<&str> {
    match path.to_str() {
        Some(text) if !text.contains(char::is_control) => Ok(text),
        _ => bail!("{path:?} cannot be written into a script; choose another folder"),
    }
}

/// The arguments of this process that make the data set, without its folder.
///
/// Names every map, so that no task takes a map that came later for a part, or does without one that went.
fn dataset_words(ids: &[u32]) -> Vec<String> {
    let mut words = command_line::own_without(&OWN_OPTIONS);
    words.retain(|word| word != "--submit");
    words[0] = "dataset".into();
    words.extend(["--map-ids".into(), ranges(ids)]);
    words
}

/// Words that tell `verify` the maps: none where it makes them itself.
fn maps_words(order: &Order) -> Vec<String> {
    let (maps, tiles) = (&order.maps, order.tiles.settings());
    let mut words = Vec::new();
    if !matches!(maps, NamedMaps::Synthetic { .. }) {
        words.extend(["--maps".into(), maps.to_string()]);
    }
    if matches!(maps, NamedMaps::City { .. }) {
        words.extend(["--tile".into(), tiles.tile_m.to_string()]);
        words.extend(["--min-buildings".into(), tiles.min_buildings.to_string()]);
        words.extend(tiles.metric.then(|| "--metric".into()));
        words.extend(tiles.all_polygons.then(|| "--all-polygons".into()));
        if let Some([x, y]) = tiles.corner {
            words.extend(["--corner".into(), format!("{x},{y}")]);
        }
    }
    words
}

/// Puts this program beside the scripts, so that all tasks run the same one, also if it is built anew in the meantime.
fn copy_program(to: &Path) -> Result<()> {
    let own = std::env::current_exe().context("cannot tell where this program is")?;
    if own == *to {
        return Ok(());
    }
    let place = || format!("cannot copy this program to '{}'", to.display());
    let partial = to.with_extension("partial");
    fs::copy(own, &partial).with_context(place)?;
    // A running program cannot be written to, but its name can be given to another file.
    fs::rename(&partial, to).with_context(place)
}
