//! `cargo xtask relabel`: other labels for the paths of a data set.

use std::path::PathBuf;

use anyhow::{Context, Result};
use aps_data::Dataset;
use aps_label::{LabelConfig, Protocol};
use map2aps::{relabel, settings};

use crate::args::{self, ArrayArgs, DelayArgs, Store};
use crate::command_line;
use crate::progress::{self, Bar};
use crate::say;
use crate::summary::Summary;

/// Label the stored paths of a data set anew: another array, bandwidth, delay grid or protocol, without a trace.
///
/// Settings that are not given are as in the data set's own labels.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of a finished data set that stores paths.
    dataset: PathBuf,
    /// Folder of the new data set; an unfinished one is continued.
    #[arg(long)]
    out: PathBuf,
    /// Definition of the label: paper, or released (what the published code computes). Brings its delay grid along.
    #[arg(long)]
    protocol: Option<Protocol>,
    #[command(flatten)]
    array: ArrayArgs,
    #[command(flatten)]
    delays: DelayArgs,
    /// Data to store: any of aps,pdp,paths [default: as the data set does].
    #[arg(long, value_enum, value_delimiter = ',')]
    store: Option<Vec<Store>>,
    /// Threads [default: all cores]. The result does not depend on it.
    #[arg(long)]
    threads: Option<usize>,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        progress::use_threads(self.threads)?;
        let source = Dataset::open(&self.dataset)?;
        let manifest = source.manifest();
        let own = settings::label_of(&manifest.configuration)
            .with_context(|| format!("data set '{}'", self.dataset.display()))?;
        let stored = match &self.store {
            Some(store) => args::stored(store),
            None => manifest.layout.stored(),
        };
        let bar = Bar::default();
        let command = command_line::own_without(&["--out", "--threads"]);
        let control = bar.control(&command)?;
        let made = relabel(&source, &self.out, &self.label(&own), stored, &control)?;
        bar.clear();
        say!("{}", Summary(&made))?;
        say!("data set '{}'", self.out.display())
    }

    fn label(&self, own: &LabelConfig) -> LabelConfig {
        let own = own.under(self.protocol.unwrap_or(own.protocol));
        LabelConfig {
            delay_axis: self.delays.over(own.delay_axis),
            ..self.array.over(&own)
        }
    }
}
