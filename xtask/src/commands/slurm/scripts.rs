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
        let options = [
            format!("--array={}%{}", self.shards, self.at_once),
            cores,
            "--requeue".into(),
            "--signal=B:USR1@120".into(),
        ];
        let values = [
            ("@TASKS@", self.tasks.to_string()),
            ("@RETRIES@", self.retries.to_string()),
            ("@OPTIONS@", self.options("%A_%a", &options)),
            ("@DATASET@", words(&self.dataset)),
        ];
        self.fill(include_str!("array.sh"), &values)
    }

    /// The script that joins the shards and checks the result.
    pub fn merge(&self) -> String {
        let maps: Vec<&str> = self.maps.iter().map(String::as_str).collect();
        let verify = words([&["verify", self.out][..], &maps].concat());
        let options = self.options("merge_%j", &[]);
        let values = [("@OPTIONS@", options), ("@VERIFY@", verify)];
        self.fill(include_str!("merge.sh"), &values)
    }

    /// The script that submits both: run by hand, or by `--submit`.
    pub fn submit(&self) -> String {
        let script = |name: &str| quoted(&format!("{}/{name}", self.folder));
        let last = self
            .last_shard
            .map_or(String::new(), |last| last.to_string());
        let values = [
            ("@LAST@", last),
            ("@ARRAY@", script(ARRAY)),
            ("@MERGE@", script(MERGE)),
            ("@LOG@", script("log")),
        ];
        let template = match self.last_shard {
            None => include_str!("submit_merge.sh"),
            Some(_) => include_str!("submit.sh"),
        };
        self.fill(template, &values)
    }

    /// A template with these values, and those that all have.
    fn fill(&self, template: &str, values: &[(&str, String)]) -> String {
        let common = [
            ("@PROGRAM@", quoted(&format!("{}/{PROGRAM}", self.folder))),
            ("@OUT@", quoted(self.out)),
            ("@COMMAND@", self.command.clone()),
        ];
        // Every template is split at its marks once, so that a mark within a value stays as it is.
        let marks = || common.iter().chain(values);
        let mut filled = String::new();
        let mut rest = template;
        while let Some((at, (mark, value))) = marks()
            .filter_map(|pair| Some((rest.find(pair.0)?, pair)))
            .min_by_key(|(at, _)| *at)
        {
            filled += &rest[..at];
            filled += value;
            rest = &rest[at + mark.len()..];
        }
        filled + rest
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
}
