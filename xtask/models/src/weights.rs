//! Weights on the command line, and advice on them.

use std::path::{Path, PathBuf};

use anyhow::{Error, Result, anyhow, bail, ensure};
use aps_model::weights::{Label, LoadReport};
use aps_model::{ModelKind, Preset};
use map2aps::MapError;
use map2aps::training::TrainingError;
use xtask::note;

use crate::choices::models;

/// Weights, and the model that they are of.
#[derive(Debug, clap::Args)]
pub struct WeightsArgs {
    /// Model of the weights [default: as their file says]. Without --weights, those that come with the program: of ms_areg and polar_reg.
    #[arg(long, value_parser = models())]
    model: Option<ModelKind>,
    /// Its sizes: paper or small [default: as the file of weights says].
    #[arg(long)]
    preset: Option<Preset>,
    /// Weights: .safetensors, or .pt of PyTorch [default: those that come with the program].
    #[arg(long)]
    weights: Option<PathBuf>,
}

impl WeightsArgs {
    /// Reads a file of weights by `load`, or without one takes those that come with the program by `shipped`.
    pub fn read<T>(
        &self,
        load: impl FnOnce(&Path, Option<ModelKind>, Option<Preset>) -> map2aps::Result<T>,
        shipped: impl FnOnce(ModelKind) -> map2aps::Result<T>,
    ) -> Result<T> {
        let read = match (&self.weights, self.model) {
            (Some(weights), kind) => load(weights, kind, self.preset),
            (None, Some(kind)) => shipped(kind),
            (None, None) => {
                bail!("give --weights, or --model for the weights that come with the program")
            }
        };
        read.map_err(advised)
    }

    /// Tells what of a file was left out, and refuses a preset in which no weights come with the program, where these are taken.
    pub fn check(&self, taken: Label, report: &LoadReport) -> Result<()> {
        let is_shipped = self.preset.is_none_or(|asked| asked == taken.preset);
        ensure!(
            self.weights.is_some() || is_shipped,
            "the weights of {} that come with the program are of preset {}; leave --preset away, or name a file with --weights",
            taken.kind,
            taken.preset
        );
        if let (Some(weights), false) = (&self.weights, report.dropped.is_empty()) {
            note!("weights '{}': {report}", weights.display());
        }
        Ok(())
    }
}

/// Remark on images whose size nothing tells, and on what would.
pub fn size_assumed(size: usize, remedy: &str) -> String {
    format!(
        "note: nothing tells the size of the images that the model learnt, as the config.json beside weights does: {size} pixels are \
         assumed; {remedy}"
    )
}

/// Names the option that helps against an error of the library, which does not know them.
pub fn advised(error: map2aps::Error) -> Error {
    use aps_model::Error::ForeignLabel;
    match error.cause() {
        map2aps::Error::Model(ForeignLabel { .. }) => {
            Error::new(error).context("name the model with --model, and its --preset")
        }
        map2aps::Error::Training(TrainingError::Unnamed(_)) => {
            Error::new(error).context("give --model")
        }
        map2aps::Error::Training(TrainingError::OtherLabels { difference, .. }) => {
            let protocol = difference
                .learnt
                .as_str()
                .map(|p| format!("--protocol {p}"));
            let options = protocol.unwrap_or("--array, --elements and --spacing".into());
            anyhow!(
                "{:#}; `relabel` labels a data set that stores paths anew with {options}, `dataset` makes another",
                Error::new(error)
            )
        }
        map2aps::Error::Map(MapError::NoScene(_)) => Error::new(error).context("--maps"),
        _ => error.into(),
    }
}
