//! `cargo xtask export-onnx`: a trained model for other runtimes.

use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use aps_data::replace_file;
use aps_model::{ModelKind, Preset};
use map2aps::training::OnnxModel;
use xtask::{note, say};

use crate::choices::{models, must_be_shipped};
use crate::predict::{advised, size_assumed};

/// Closing section of the long help: facts that the options' single lines leave out.
const WHAT_IS_WRITTEN: &str = "\
Input and output tell their shapes and units, and the metadata how images and labels were made, if the weights lie in the
folder of a run. `batch` is any number of links:

  condition (batch, 3, size, size)  ->  spectrum (batch, 180), normalised
  ways (batch, ways, 16)            ->  the same, of polar_reg";

/// Write a trained model as a file of ONNX.
#[derive(Debug, clap::Args)]
#[command(after_long_help = WHAT_IS_WRITTEN)]
pub struct Args {
    /// Model of the weights [default: as their file says]. Without --weights, those that come with the program: of ms_areg and polar_reg.
    #[arg(long, value_parser = models())]
    model: Option<ModelKind>,
    /// Its sizes: paper or small [default: as the file of weights says].
    #[arg(long)]
    preset: Option<Preset>,
    /// Weights: .safetensors, or .pt of PyTorch [default: those that come with the program].
    #[arg(long)]
    weights: Option<PathBuf>,
    /// Rows and columns of condition images [pixels; default: as trained, by the config.json beside the weights; else
    /// 256 paper, 64 small].
    #[arg(long)]
    image_size: Option<usize>,
    /// File to write.
    #[arg(long)]
    out: PathBuf,
    /// Write it also where there is one already.
    #[arg(long)]
    overwrite: bool,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        ensure!(
            self.overwrite || !self.out.exists(),
            "'{}' is there already; replace it with --overwrite, or give another --out",
            self.out.display()
        );
        xtask::output::make_folder_of(&self.out)?;
        let size = self.image_size;
        let model = match (&self.weights, self.model) {
            (Some(weights), kind) => OnnxModel::load(weights, kind, self.preset, size),
            (None, Some(kind)) => OnnxModel::shipped(kind, size),
            (None, None) => bail!("give --weights or --model"),
        };
        let model = model.map_err(advised)?;
        must_be_shipped(self.weights.as_deref(), self.preset, model.label)?;
        if let (Some(weights), false) = (&self.weights, model.report.dropped.is_empty()) {
            note!("weights '{}': {}", weights.display(), model.report);
        }
        if let (Some(size), true) = (model.image_size, model.is_size_assumed) {
            note!("{}", size_assumed(size, "--image-size sets it"));
        }
        replace_file(&self.out, &model.bytes)
            .with_context(|| format!("cannot write '{}'", self.out.display()))?;
        say!(
            "{} in '{}', {:.1} MB{}",
            model.label.kind,
            self.out.display(),
            model.bytes.len() as f64 / 1e6,
            match model.image_size {
                Some(size) => format!(", for images of {size} pixels"),
                None => String::new(),
            }
        )
    }
}
