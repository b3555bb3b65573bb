//! `cargo xtask export-onnx`: a trained model for other runtimes.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use aps_data::replace_file;
use map2aps::training::OnnxModel;
use xtask::{note, say};

use crate::weights::{WeightsArgs, size_assumed};

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
    #[command(flatten)]
    weights: WeightsArgs,
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
        let load = |file: &_, kind, preset| OnnxModel::load(file, kind, preset, size);
        let shipped = |kind| OnnxModel::shipped(kind, size);
        let model = self.weights.read(load, shipped)?;
        self.weights.check(model.label, &model.report)?;
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
