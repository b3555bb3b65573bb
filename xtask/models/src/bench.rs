//! `cargo xtask bench-models`: the command line, as settings over those of a file.

use std::path::PathBuf;

use anyhow::{Context, Result, anyhow, bail, ensure};
use aps_bench::{Benchmark, Config, Error, Profile, Watch};
use aps_model::ModelKind;
use aps_report::benchmark::EntryKind;
use map2aps::Limits;
use map2aps::training::Device;
use toml::{Table, Value};
use xtask::interrupt::interrupt_flag;
use xtask::{limits, machine, note, say};

use crate::choices::{devices, models, profiles};
use crate::watch::Printer;

/// Closing section of the long help: facts that the options' single lines leave out.
const WHAT_IS_WRITTEN: &str = "\
What is written into --out:
  report.html, report.md    the report, with tables/*.csv and figures/*.svg
  results.json              everything the report is made of
  configuration.json        every setting
  data, models, scores      data set, weights, predictions and scores of each link

A part that was finished with the same settings is reused, an unfinished training is continued; --fresh makes all anew.
On Ctrl-C everything finished is kept. What fails is recorded, and the others go on.

A profile sets everything; --config names a TOML file that changes some of it, flags change both. The profiles' own files,
crates/aps-bench/profiles/*.toml, show all keys.";

/// Train, score and time models against each other, baselines and the tracer, and report.
#[derive(Debug, clap::Args)]
#[command(after_long_help = WHAT_IS_WRITTEN)]
pub struct Args {
    /// Sizes of everything.
    #[arg(long, value_parser = profiles(), default_value = "quick")]
    profile: Profile,
    /// TOML file of settings that differ from the profile's.
    #[arg(long)]
    config: Option<PathBuf>,
    /// A setting as in such a file, like training.links=1000; one of training is for all models. May be repeated.
    #[arg(long, value_name = "KEY=VALUE", value_parser = pair)]
    set: Vec<(String, String)>,
    /// Time of each model's training, like 60s, 10m or 1h.
    #[arg(long)]
    budget: Option<String>,
    /// Models, separated by commas [default: all].
    #[arg(long, value_delimiter = ',', value_parser = models())]
    models: Option<Vec<ModelKind>>,
    /// Folder of RadioMapSeer files 0.json, 1.json, ..., or synthetic.
    #[arg(long)]
    maps: Option<String>,
    /// Limits of the paths in labels [default: as the profile has it].
    #[arg(long, value_parser = limits())]
    limits: Option<Limits>,
    /// Seed of terminals, synthetic cities, weights, order and drawn links.
    #[arg(long)]
    seed: Option<u64>,
    /// Predictions from elsewhere: .npy, (links, 180), rows as `predict --split test` writes them. May be repeated.
    #[arg(long, value_name = "NAME=FILE", value_parser = pair)]
    external: Vec<(String, String)>,
    /// Weights trained before, scored as they are. May be repeated.
    #[arg(long, value_name = "NAME=FILE", value_parser = pair)]
    weights: Vec<(String, String)>,
    /// Choose learning rate, batch, image size and warm-up of each model by trainings of this share of the budget, scored on the
    /// development maps, and write them into the profile's file; no test map is looked at.
    #[arg(long, value_name = "SHARE")]
    tune: Option<f64>,
    /// Device of the models.
    #[arg(long, value_parser = devices())]
    device: Option<Device>,
    /// Threads [default: all cores].
    #[arg(long)]
    threads: Option<usize>,
    /// Make everything anew.
    #[arg(long)]
    fresh: bool,
    /// Folder of the benchmark [default: data/bench-PROFILE].
    #[arg(long)]
    out: Option<PathBuf>,
}

fn pair(text: &str) -> Result<(String, String), String> {
    let parts = text.split_once('=').unwrap_or_default();
    match (parts.0.trim(), parts.1.trim()) {
        ("", _) | (_, "") => Err(format!("'{text}' must be NAME=VALUE")),
        (name, value) => Ok((name.into(), value.into())),
    }
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        xtask::use_threads(self.threads)?;
        let config = Config::resolve(self.profile, self.config.as_deref(), self.flags()?)?;
        let usual = || PathBuf::from(format!("data/bench-{}", self.profile.name()));
        let out = self.out.clone().unwrap_or_else(usual);
        let cancel = interrupt_flag()?;
        let printer = Printer::new(cancel);
        let watch = Watch {
            observer: &printer,
            cancel,
        };
        let profile = config.profile_name(self.profile);
        let mut bench = Benchmark::new(config, &out)?;
        bench.profile = profile.into();
        bench.fresh = self.fresh;
        if let Some(share) = self.tune {
            let is_share = share > 0.0 && share.is_finite();
            ensure!(is_share, "--tune is {share}: must be positive");
            let file = self.profile.path();
            let tuned = bench.tune(share, &file, watch);
            printer.printed()?;
            tuned.map_err(advised)?;
            note!("written into '{}'; the next build takes it", file.display());
            return Ok(());
        }
        bench.machine = machine::describe();
        let results = bench.run(watch).map_err(advised)?;
        for failure in &results.failed {
            say!("failed: {}: {}", failure.name, failure.message)?;
        }
        for reason in &results.left_out {
            say!("left out: {}: {}", reason.name, reason.message)?;
        }
        say!("{}", out.join("report.html").display())?;
        let mut entries = results.entries.iter();
        let has_model = entries.any(|entry| entry.kind == EntryKind::Model);
        match results.failed.len() {
            0 => Ok(()),
            _ if !has_model => bail!("every model failed"),
            count => bail!("failed entries: {count}; the report holds the others"),
        }
    }

    /// The flags that were given, as a file would say it.
    fn flags(&self) -> Result<Table> {
        let mut flags = Table::new();
        for (key, text) in &self.set {
            // What is no number, list or quoted text is a word.
            let parsed = format!("value = {text}").parse::<Table>().ok();
            let value = parsed.and_then(|mut table| table.remove("value"));
            let value = value.unwrap_or_else(|| Value::from(text.as_str()));
            Config::flag(&mut flags, &key.split('.').collect::<Vec<_>>(), value)?;
        }
        let seed = self.seed.map(i64::try_from).transpose();
        let seed = seed.context("a seed must be below 2^63")?;
        let names = |kinds: &Vec<ModelKind>| {
            Value::from(kinds.iter().map(|kind| kind.name()).collect::<Vec<_>>())
        };
        let text = |text: &Option<String>| text.clone().map(Value::from);
        let given = [
            (["seed"].as_slice(), seed.map(Value::from)),
            (&["models"], self.models.as_ref().map(names)),
            (&["device"], self.device.map(Value::try_from).transpose()?),
            (&["data", "maps"], text(&self.maps)),
            (
                &["data", "limits"],
                self.limits.map(Value::try_from).transpose()?,
            ),
            (&["training", "budget"], text(&self.budget)),
        ];
        for (key, value) in given {
            if let Some(value) = value {
                Config::flag(&mut flags, key, value)?;
            }
        }
        for (table, pairs) in [("external", &self.external), ("weights", &self.weights)] {
            for (name, file) in pairs {
                let file = Value::from(file.as_str());
                Config::flag(&mut flags, &[table, name.as_str()], file)?;
            }
        }
        Ok(flags)
    }
}

/// Names the option that helps against an error of the library, which does not know them.
fn advised(error: Error) -> anyhow::Error {
    match error {
        Error::ForeignFolder(_) => anyhow!("{error}; give another --out"),
        Error::NoBudget => anyhow!("--tune is for a profile with a budget"),
        Error::Share { share, budget_s } => {
            anyhow!("--tune {share} leaves a training less than a millisecond of {budget_s} s")
        }
        // Its advice is xtask's.
        Error::Library(error) => error.into(),
        error => error.into(),
    }
}
