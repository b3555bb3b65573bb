//! The command line of `bench-models`, as settings over those of a file.

use std::path::PathBuf;

use anyhow::{Context, Result};
use map2aps::training::Device;
use toml::{Table, Value};
use xtask::interrupt::interrupt_flag;

use super::Bench;
use super::config::{Config, Profile};
use crate::choices::devices;

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
xtask/models/profiles/*.toml, show all keys.";

/// Train, score and time models against each other, baselines and the tracer, and report.
#[derive(Debug, clap::Args)]
#[command(after_long_help = WHAT_IS_WRITTEN)]
pub struct Args {
    /// Sizes of everything.
    #[arg(long, value_enum, default_value_t = Profile::Quick)]
    profile: Profile,
    /// TOML file of settings that differ from the profile's.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Models, separated by commas: any of ms_areg, ms_mlp, adv_mlp, resnet_mlp, radiounet, vit_reg, resnet_conv1d.
    #[arg(long, value_delimiter = ',')]
    models: Option<Vec<String>>,
    /// Folder of RadioMapSeer files 0.json, 1.json, ..., or synthetic.
    #[arg(long)]
    maps: Option<String>,
    /// Definition of the labels: released or paper. Scores are given by both.
    #[arg(long)]
    protocol: Option<String>,
    /// Sizes of the models: small or paper.
    #[arg(long)]
    preset: Option<String>,
    /// Rows and columns of condition images, of all models [pixels].
    #[arg(long)]
    image_size: Option<usize>,
    /// Times each link is learnt from, by all models.
    #[arg(long)]
    epochs: Option<usize>,
    /// Links to learn from, for all models.
    #[arg(long)]
    links: Option<usize>,
    /// Links a step, of all models.
    #[arg(long)]
    batch: Option<usize>,
    /// Test links scored, drawn by the seed.
    #[arg(long)]
    test_links: Option<usize>,
    /// Seed of terminals, synthetic cities, weights, order and drawn links.
    #[arg(long)]
    seed: Option<u64>,
    /// Predictions from elsewhere: .npy, (links, 180), rows as `predict --split test` writes them. May be repeated.
    #[arg(long, value_name = "NAME=FILE", value_parser = external)]
    external: Vec<(String, String)>,
    /// Where models compute.
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

fn external(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, file)) if !name.is_empty() && !file.is_empty() => {
            Ok((name.into(), file.into()))
        }
        _ => Err(format!("'{text}' is not NAME=FILE")),
    }
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        xtask::use_threads(self.threads)?;
        let config = Config::resolve(self.profile, self.config.as_deref(), self.flags()?)?;
        let profile = config.profile_name(self.profile);
        let usual = || PathBuf::from(format!("data/bench-{}", self.profile.name()));
        let interrupted = interrupt_flag()?;
        let bench = Bench {
            profile,
            device: config.device.open()?,
            config,
            out: self.out.unwrap_or_else(usual),
            fresh: self.fresh,
            interrupted,
        };
        bench.run()
    }

    /// The flags that were given, as a file would say it.
    fn flags(&self) -> Result<Table> {
        let text = |text: &Option<String>| text.clone().map(Value::String);
        let number = |number: Option<u64>| -> Result<Option<Value>> {
            let number = number.map(i64::try_from).transpose();
            Ok(number
                .context("numbers must be below 2^63")?
                .map(Value::Integer))
        };
        let size = |size: Option<usize>| number(size.map(|n| n as u64));
        let device = self.device.map(Value::try_from).transpose()?;
        let models = self.models.clone().map(Value::from);
        let external = self.external.iter().cloned();
        let external: Table = external
            .map(|(name, file)| (name, Value::String(file)))
            .collect();
        let table = |entries: Vec<(&str, Option<Value>)>| -> Table {
            let given = entries.into_iter();
            given
                .filter_map(|(key, value)| Some((key.to_owned(), value?)))
                .collect()
        };
        let data = table(vec![
            ("maps", text(&self.maps)),
            ("protocol", text(&self.protocol)),
            ("test_links", size(self.test_links)?),
        ]);
        let training = table(vec![
            ("preset", text(&self.preset)),
            ("image_size", size(self.image_size)?),
            ("epochs", size(self.epochs)?),
            ("links", size(self.links)?),
            ("batch", size(self.batch)?),
        ]);
        let of = |table: Table| (!table.is_empty()).then_some(Value::Table(table));
        Ok(table(vec![
            ("seed", number(self.seed)?),
            ("models", models),
            ("device", device),
            ("data", of(data)),
            ("training", of(training)),
            ("external", of(external)),
        ]))
    }
}
