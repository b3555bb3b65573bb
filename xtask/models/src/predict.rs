//! `cargo xtask predict`: spectra from trained weights.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use aps_data::npy::{self, Element};
use aps_data::{Dataset, Part};
use aps_model::candle_core::{self, Tensor};
use aps_model::train::predict;
use aps_model::weights::Label;
use aps_model::{ANGLE_BINS, Model, ModelKind, Preset};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};

use crate::data::{self, Buildings};
use crate::device::Device;
use crate::labels::{Labels, Row, valid_links};
use crate::network;
use crate::settings::Settings;
use xtask::note;

/// Parts of a data set's split.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Split {
    /// Maps to fit a model's weights on.
    Train,
    /// Maps to choose a model by.
    Develop,
    /// Maps for the figures that are reported.
    Test,
}

/// Closing section of the long help: facts that the options' single lines leave out.
const WHAT_IS_WRITTEN: &str = "\
With --data the links with a label (status 0) of the split's maps are predicted: maps in ascending order, links in the
order of their rows. This is what the metrics expect:

  cargo xtask metrics --truth DATA --split test --prediction pred.npy

pred.links.csv, beside pred.npy, names map, row, transmitter and receiver of each.

With --input, condition images of any origin are predicted: .npy, float32, shape (samples, 3, size, size): buildings,
transmitter heatmap, receiver heatmap, of the size the model was trained on.";

/// Predict spectra with a trained model.
#[derive(Debug, clap::Args)]
#[command(after_long_help = WHAT_IS_WRITTEN)]
pub struct Args {
    /// Model of the weights [default: as their file says].
    #[arg(long)]
    model: Option<ModelKind>,
    /// Its sizes: paper or small [default: as the file of weights says].
    #[arg(long)]
    preset: Option<Preset>,
    /// Weights: .safetensors, or .pt of PyTorch.
    #[arg(long)]
    weights: PathBuf,
    /// Folder of a data set.
    #[arg(long, required_unless_present = "input", conflicts_with = "input")]
    data: Option<PathBuf>,
    /// Part of the data set [default: test].
    #[arg(long, value_enum, conflicts_with = "input")]
    split: Option<Split>,
    /// Condition images: .npy file.
    #[arg(long)]
    input: Option<PathBuf>,
    /// Rows and columns of condition images [pixels; default: as trained, by the config.json beside the weights; else
    /// 256 paper, 64 small].
    #[arg(long, conflicts_with = "input")]
    image_size: Option<usize>,
    /// Links predicted at a time.
    #[arg(long, default_value_t = 64)]
    batch: usize,
    /// Where to compute.
    #[arg(long, value_enum, default_value_t = Device::Cpu)]
    device: Device,
    /// Threads [default: all cores].
    #[arg(long)]
    threads: Option<usize>,
    /// File to write: .npy, (links, 180), float32.
    #[arg(long)]
    out: PathBuf,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        xtask::use_threads(self.threads)?;
        ensure!(self.batch > 0, "--batch must be at least 1");
        let device = self.device.open()?;
        let label = network::label_of(&self.weights, self.model, self.preset)?;
        let (model, _) = network::load(&self.weights, label, &device)?;
        match (&self.data, &self.input) {
            (Some(root), _) => self.of_dataset(root, label, &*model, &device),
            (None, Some(images)) => self.of_images(images, &*model, &device),
            (None, None) => bail!("give --data or --input"),
        }
    }

    fn of_dataset(
        &self,
        root: &Path,
        label: Label,
        model: &dyn Model,
        device: &candle_core::Device,
    ) -> Result<()> {
        let dataset = data::open(root)?;
        let part = match self.split.unwrap_or(Split::Test) {
            Split::Train => Part::Train,
            Split::Develop => Part::Develop,
            Split::Test => Part::Test,
        };
        let maps = dataset.manifest().split.maps(part);
        ensure!(
            !maps.is_empty(),
            "data set '{}' has no {part:?} maps",
            root.display()
        );
        let trained = Settings::beside(&self.weights)?;
        let image_size = self.image_size_of(label, trained.as_ref());
        if let Some(trained) = &trained {
            warn_of_differences(trained, &dataset, root);
        }
        let mut output = Output::create(&self.out, valid_links(&dataset, maps))?;
        let names = csv::Writer::from_path(self.links_path());
        let mut names =
            names.with_context(|| format!("cannot create '{}'", self.links_path().display()))?;
        names.write_record([
            "row", "map", "link", "tx", "rx", "tx_x_m", "tx_y_m", "rx_x_m", "rx_y_m",
        ])?;
        // A map at a time: its labels are not needed, but its links and buildings are.
        for &id in maps {
            let buildings = Buildings::load(&dataset, [id])?;
            let input = buildings.input(label.kind, false, image_size, device)?;
            let any = aps_label::Normalization::Paper(aps_label::MeanStd {
                mean: 0.0,
                std: 1.0,
            });
            let labels = Labels::load(&dataset, &[id], &buildings.index_of, None, 0, any)?;
            for (offset, (row, link)) in labels.rows().iter().zip(labels.links()).enumerate() {
                let Row {
                    map,
                    link: of_map,
                    tx,
                    rx,
                } = *row;
                let numbers = [
                    (output.rows + offset) as u64,
                    map.into(),
                    of_map.into(),
                    tx.into(),
                    rx.into(),
                ];
                let ends = [link.tx_m, link.rx_m].concat();
                let cells = numbers
                    .iter()
                    .map(u64::to_string)
                    .chain(ends.iter().map(f64::to_string));
                names.write_record(cells)?;
            }
            let links = labels.links().iter().copied();
            predict(model, &*input, links, self.batch, |_, spectra| {
                output.push(spectra)
            })?;
        }
        names.flush()?;
        let rows = output.finish()?;
        note!(
            "{rows} spectra of the {part:?} maps {maps:?} in '{}', their links in '{}'",
            self.out.display(),
            self.links_path().display()
        );
        Ok(())
    }

    fn of_images(
        &self,
        path: &Path,
        model: &dyn Model,
        device: &candle_core::Device,
    ) -> Result<()> {
        let place = || format!("images '{}'", path.display());
        let images = npy::read::<f32>(path).with_context(place)?;
        let [samples, 3, height, width] = images.shape[..] else {
            bail!(
                "{} have shape {:?}, expected (samples, 3, height, width)",
                place(),
                images.shape
            );
        };
        if let Some(bad) = images.data.iter().position(|x| !x.is_finite()) {
            bail!(
                "{}: sample {} holds {}",
                place(),
                bad / (3 * height * width),
                images.data[bad]
            );
        }
        if let Some(trained) = Settings::beside(&self.weights)? {
            let size = trained.image_size;
            ensure!(
                (height, width) == (size, size),
                "{} are {height} x {width}, the model was trained on {size} x {size}",
                place()
            );
        }
        let mut output = Output::create(&self.out, samples)?;
        let image = 3 * height * width;
        for batch in images.data.chunks(self.batch * image.max(1)) {
            let shape = (batch.len() / image, 3, height, width);
            let spectra = model.forward_t(&Tensor::from_slice(batch, shape, device)?, false);
            let spectra = spectra
                .with_context(place)?
                .flatten_all()?
                .to_vec1::<f32>()?;
            if let Some(bad) = spectra.iter().position(|x| !x.is_finite()) {
                let sample = output.rows + bad / ANGLE_BINS;
                bail!(
                    "the prediction of sample {sample} is not finite: the weights are damaged, or belong elsewhere"
                );
            }
            output.push(&spectra)?;
        }
        let rows = output.finish()?;
        note!("{rows} spectra in '{}'", self.out.display());
        Ok(())
    }

    fn image_size_of(&self, label: Label, trained: Option<&Settings>) -> usize {
        let trained = trained.map(|settings| settings.image_size);
        if let (Some(asked), Some(trained)) = (
            self.image_size,
            trained.filter(|&t| Some(t) != self.image_size),
        ) {
            note!("note: the model was trained on images of {trained} pixels, not {asked}");
        }
        self.image_size
            .or(trained)
            .unwrap_or(network::image_size(label.preset))
    }

    fn links_path(&self) -> PathBuf {
        self.out.with_extension("links.csv")
    }
}

/// Warns of differences between training and data set with which predictions are possible but hardly good.
fn warn_of_differences(trained: &Settings, dataset: &Dataset, root: &Path) {
    let here = dataset.manifest().configuration.get("label");
    if trained.data_configuration.get("label") != here {
        note!(
            "note: the model was trained on labels made with other settings than those of '{}'",
            root.display()
        );
    }
}

/// A growing array of spectra.
struct Output {
    writer: npy::Writer<BufWriter<File>>,
    path: PathBuf,
    rows: usize,
    bar: ProgressBar,
}

impl Output {
    fn create(path: &Path, rows: usize) -> Result<Self> {
        let file =
            File::create(path).with_context(|| format!("cannot create '{}'", path.display()))?;
        let style = ProgressStyle::with_template(
            "[{bar:40}] {human_pos}/{human_len} spectra, {per_sec}, {eta} left",
        )
        .expect("the template is well formed")
        .progress_chars("=> ");
        Ok(Self {
            writer: npy::Writer::new(BufWriter::new(file), f32::DTYPE, &[ANGLE_BINS])?,
            path: path.into(),
            rows: 0,
            bar: ProgressBar::new(rows as u64).with_style(style),
        })
    }

    fn push(&mut self, spectra: &[f32]) -> Result<()> {
        let written = self.writer.push(spectra);
        written.with_context(|| format!("cannot write '{}'", self.path.display()))?;
        let rows = spectra.len() / ANGLE_BINS;
        self.rows += rows;
        self.bar.inc(rows as u64);
        Ok(())
    }

    fn finish(self) -> Result<usize> {
        self.bar.finish_and_clear();
        let finished = self.writer.finish();
        let (_, rows) =
            finished.with_context(|| format!("cannot write '{}'", self.path.display()))?;
        Ok(rows)
    }
}
