//! `cargo xtask metrics`: predictions of any model against the truth.

mod output;

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use aps_data::Part;
use aps_label::Protocol;
use aps_metrics::DataRange;
use map2aps::{ArrayFile, Domain, Prediction, Scoring, Truth};

use crate::args::{domains, parts};
use crate::note;

/// Closing section of the long help: facts that the options' single lines leave out.
const WHAT_IS_COMPARED: &str = "\
What is compared:
  Two files are compared as they are: .npy, shape (samples, bins), float16, float32 or float64.
  They may be larger than memory. docs/protocol.md defines the metrics.

  With a data set as truth, row i of the prediction belongs to the i-th link with a label
  (status 0) of the split's maps: maps in ascending order, links in the order of their rows.
  The truth is made from the stored dB values:

  --domain normalised: x = 10^(dB/10) relative to the link's maximum, then (x - mean) / std with
    mean and std of x over the training maps; under the released protocol each link is then
    standardised by its own mean and deviation (+ 1e-8). The prediction must be this target, as
    a model trained on it puts it out. The result states mean and std.
  --domain linear: the prediction must be x itself. The numbers are then not the paper's.";

/// Score predictions of any model against labels.
#[derive(Debug, clap::Args)]
#[command(after_long_help = WHAT_IS_COMPARED)]
pub struct Args {
    /// True spectra: .npy file, or folder of a data set.
    #[arg(long)]
    truth: PathBuf,
    /// Part of the data set to score on [default: test].
    #[arg(long, value_parser = parts())]
    split: Option<Part>,
    /// Predicted spectra: .npy file.
    #[arg(long)]
    prediction: PathBuf,
    /// Map of each sample: .npy file of shape (samples), integers. A data set knows its own.
    #[arg(long)]
    map_ids: Option<PathBuf>,
    /// Definition of the metrics: paper or released [default: the data set's; paper for files].
    #[arg(long)]
    protocol: Option<Protocol>,
    /// Form in which a data set's labels are compared [default: normalised].
    #[arg(long, value_parser = domains())]
    domain: Option<Domain>,
    /// Range of the truth that PSNR is relative to [default: largest minus smallest true value].
    #[arg(long)]
    data_range: Option<f64>,
    /// Form of the result.
    #[arg(long, value_enum, default_value_t = output::Format::Table)]
    format: output::Format,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let data_range = self.data_range.map(DataRange::new).transpose()?;
        let mut truth = self.open_truth()?;
        let scoring = Scoring {
            protocol: self.protocol,
            map_ids: match &self.map_ids {
                Some(path) => Some(ArrayFile::open_ids(path).context("map ids")?),
                None => None,
            },
            data_range,
        };
        let protocol = scoring.protocol(&truth);
        if let Some(own) = truth.own_protocol().filter(|&own| own != protocol) {
            note!(
                "note: the labels were made under the {own} protocol, on its angle grid; \
                 they are scored under the {protocol} one"
            );
        }
        let prediction = ArrayFile::open_spectra(&self.prediction);
        let prediction = prediction
            .with_context(|| format!("prediction for {truth}, of shape {}", truth.shape()))?;
        let scores = scoring.score(&mut truth, Prediction::File(prediction))?;
        let result = output::Printed {
            truth: &truth,
            prediction: &self.prediction,
            scores: &scores,
        };
        result.warn();
        result.print(self.format)
    }

    fn open_truth(&self) -> Result<Truth> {
        if self.truth.is_dir() {
            ensure!(
                self.map_ids.is_none(),
                "--map-ids is for truth from a file; a data set knows its maps"
            );
            let part = self.split.unwrap_or(Part::Test);
            let domain = self.domain.unwrap_or_default();
            Ok(Truth::dataset(&self.truth, part, domain)?)
        } else {
            ensure!(
                self.split.is_none() && self.domain.is_none(),
                "--split and --domain are for a data set, but '{}' is no folder; \
                 files are compared as they are",
                self.truth.display()
            );
            let file = ArrayFile::open_spectra(&self.truth).context("truth")?;
            Ok(Truth::File(file))
        }
    }
}
