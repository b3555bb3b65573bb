//! The scripts of a campaign: bash, as an administrator would want to read them.

use crate::command_line::{quoted, words};

/// File of the job array.
pub const ARRAY: &str = "array.sh";
/// File of the job that joins and checks.
pub const MERGE: &str = "merge.sh";
/// File that submits both.
pub const SUBMIT: &str = "submit.sh";
/// The program that they run.
pub const PROGRAM: &str = "xtask";

/// Values that the scripts are made from.
pub struct Job<'a> {
    /// Folder in which the command was given, and in which relative paths hold.
    pub here: &'a str,
    /// Absolute folder of scripts, program and logs.
    pub folder: &'a str,
    /// Folder of the data set.
    pub out: &'a str,
    /// Words of the command that makes the data set, without its folder.
    pub dataset: Vec<String>,
    /// Words that tell `verify` the maps.
    pub maps: Vec<String>,
    /// Number of shards.
    pub tasks: u32,
    /// Numbers of the shards to make, like `1-4,7`; empty if every map is made.
    pub shards: String,
    /// Highest number of a shard to make.
    pub last_shard: Option<u32>,
    /// Most tasks at once.
    pub at_once: u32,
    /// Cores of a task; all of its node if not given.
    pub cpus: Option<u32>,
    /// Times that a failing task is queued again.
    pub retries: u32,
    /// Further options for sbatch.
    pub sbatch: &'a [String],
    /// The command that wrote the scripts.
    pub command: String,
}

impl Job<'_> {
    /// The script of a task: makes one shard.
    pub fn array(&self) -> String {
        let cores = match self.cpus {
            None => "--exclusive".into(),
            Some(cpus) => format!("--cpus-per-task={cpus}"),
        };
        let options = self.options(
            "%A_%a",
            &[
                format!("--array={}%{}", self.shards, self.at_once),
                cores,
                "--requeue".into(),
                "--signal=B:USR1@120".into(),
            ],
        );
        let Self { tasks, retries, .. } = self;
        let program = self.program();
        let (dataset, out) = (words(&self.dataset), quoted(self.out));
        format!(
            r#"#!/usr/bin/env bash
# Makes one shard of a data set: task I of the array makes the maps with id mod {tasks} = I - 1.
#
# Tasks do not wait for each other. One that fails, or has two minutes left, goes back into the queue by itself, at most
# {retries} times, and then goes on after the maps it has finished. What a killed task leaves half-written is never taken for a
# map.
{written}
{options}
set -u
shard="$SLURM_ARRAY_TASK_ID/{tasks}"

# Ends this run of the task; the reason is the first argument.
end() {{
    # Slurm counts how often it started this task again; at first there is no such number.
    if [ "${{SLURM_RESTART_COUNT:-0}}" -lt {retries} ]; then
        echo "shard $shard: $1; back into the queue" >&2
        # The number of the job alone would mean the whole array.
        scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID" && exit 0
    fi
    echo "shard $shard: $1; given up" >&2
    exit 1
}}

# In the background, for bash does not listen to signals while it waits for a command in the foreground.
{program} {dataset} \
    --out {out} --shard "$shard" --threads "$SLURM_CPUS_ON_NODE" &
program=$!
trap 'kill -TERM "$program"; wait "$program"; end "out of time"' USR1
wait "$program"
status=$?
[ "$status" -eq 0 ] || end "exit code $status"
echo "shard $shard: done"
"#,
            written = self.written(),
        )
    }

    /// The script that joins the shards and checks the result.
    pub fn merge(&self) -> String {
        let options = self.options("merge_%j", &[]);
        let (program, out) = (self.program(), quoted(self.out));
        let maps: Vec<&str> = self.maps.iter().map(String::as_str).collect();
        let verify = words([&["verify", self.out][..], &maps].concat());
        format!(
            r#"#!/usr/bin/env bash
# Joins all shards into the data set that one run would have written, byte for byte, and checks it: every file against its
# checksum, and some links by computing them anew.
{written}
{options}
set -eu

{program} dataset merge --out {out}
{program} {verify} --threads "$SLURM_CPUS_ON_NODE"
"#,
            written = self.written(),
        )
    }

    /// The script that submits both: run by hand, or by `--submit`.
    pub fn submit(&self) -> String {
        let script = |name: &str| quoted(&format!("{}/{name}", self.folder));
        let merge = script(MERGE);
        let jobs = match self.last_shard {
            None => format!(
                r#"# All maps are there.
merge=$(sbatch --parsable {merge})
echo "merge: job ${{merge%%;*}}"
"#
            ),
            Some(last) => format!(
                r#"# Numbers of tasks stay below this; sbatch would only call the array invalid.
limit=$(scontrol show config 2>/dev/null | sed -n 's/^MaxArraySize *= *//p')
if [ -n "$limit" ] && [ {last} -ge "$limit" ]; then
    echo "this cluster numbers tasks up to $((limit - 1)) (MaxArraySize), here the last is {last};" \
        "write the scripts again with --tasks $((limit - 1)) or less" >&2
    exit 1
fi
array=$(sbatch --parsable {array})
# Behind the number stands the cluster, where there are several.
array=${{array%%;*}}
echo "array: job $array"
# Starts when all tasks have ended well; is withdrawn when one has been given up. The command above then submits it alone.
merge=$(sbatch --parsable --dependency="afterok:$array" --kill-on-invalid-dep=yes {merge})
echo "merge: job ${{merge%%;*}}"
"#,
                array = script(ARRAY)
            ),
        };
        let log = quoted(&format!("{}/log", self.folder));
        format!(
            r#"#!/usr/bin/env bash
# Submits the array, and the job that waits for it.
{written}
set -eu

{jobs}echo "to watch: squeue --me; logs in "{log}
"#,
            written = self.written(),
        )
    }

    /// Lines with the options of Slurm that all jobs have and the job's `own`, with a log of this name.
    fn options(&self, log: &str, own: &[String]) -> String {
        // A percent sign in the name of a folder is not one of Slurm's.
        let log = format!("{}/log/{log}.log", self.folder.replace('%', "%%"));
        let name = self.out.rsplit('/').find(|part| !part.is_empty());
        let mut options = vec![
            format!("--job-name={}", name.unwrap_or("dataset")),
            format!("--chdir={}", self.here),
            format!("--output={log}"),
            "--open-mode=append".into(),
            "--nodes=1".into(),
            "--ntasks=1".into(),
        ];
        options.extend_from_slice(own);
        options.extend_from_slice(self.sbatch);
        let lines = options.iter().map(|option| match option.split_once('=') {
            Some((name, value)) => format!("#SBATCH {name}={}", quoted(value)),
            None => format!("#SBATCH {option}"),
        });
        lines.collect::<Vec<_>>().join("\n")
    }

    fn program(&self) -> String {
        quoted(&format!("{}/{PROGRAM}", self.folder))
    }

    fn written(&self) -> String {
        format!("#\n# Written by: {}", self.command)
    }
}
