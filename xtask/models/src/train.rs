//! `cargo xtask train`: a data set in, weights out.

use std::num::NonZeroU64;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

use anyhow::{Error, Result, ensure};
use aps_data::Dataset;
use aps_model::condition::{Frame, InputKind};
use aps_model::train::{Precision, TrainConfig};
use aps_model::{ModelKind, Preset};
use map2aps::maps::NamedMaps;
use map2aps::training::{
    self, DevelopmentMaps, Device, InitialWeights, RunFolder, Selection, Training, TrainingError,
    usual_image_size,
};
use map2aps::{Control, MapError};
use xtask::TileArgs;
use xtask::interrupt::interrupt_flag;

use crate::choices::{devices, frames, models, precisions};
use crate::run;

/// Closing section of the long help: facts that the options' single lines leave out.
const WHAT_IS_WRITTEN: &str = "\
What is written into --out:
  best.safetensors   weights with the least error on the development maps, of those scored: mean absolute error for
                     models trained on it (ms_areg, adv_mlp, polar_reg), mean squared error for the others
  last.safetensors   everything needed to continue (--resume), written after each epoch, each 1000 steps, on Ctrl-C
  config.json        every setting
  steps.csv          loss, gradient norms and learning rate of each step
  scores.csv         after each epoch, or 1/16, 1/8, 1/4, 1/2, 3/4 and all of --budget, and each --score-every steps: mean loss
                     since the row before, and all metrics on the development maps
  times.csv          time spent before each row of scores.csv

A run of epochs that is stopped and continued writes the same bytes as one that is not, but for times.csv, on a CPU with any
number of threads.
Test maps are never looked at: score them with `predict --split test` and `metrics`.";

/// Train a model on a data set.
#[derive(Debug, clap::Args)]
#[command(after_long_help = WHAT_IS_WRITTEN)]
pub struct Args {
    /// Model to train.
    #[arg(long, value_parser = models())]
    model: ModelKind,
    /// Folder of the data set.
    #[arg(long)]
    data: PathBuf,
    /// Maps that the data set was made from, for polar_reg, which is given outlines of buildings: a folder of RadioMapSeer files,
    /// or a city in GeoJSON. Synthetic cities need not be given.
    #[arg(long)]
    maps: Option<NamedMaps>,
    #[command(flatten)]
    tiles: TileArgs,
    /// Sizes of the model: paper, or small for a CPU.
    #[arg(long, default_value_t = Preset::Small)]
    preset: Preset,
    /// Rows and columns of condition images [pixels; default: 256 paper, 64 small; none for polar_reg].
    #[arg(long)]
    image_size: Option<usize>,
    /// Part of the plane that condition images show: the whole map, as in the paper, or a window as large about the receiver.
    #[arg(long, default_value_t = Frame::Map, value_parser = frames())]
    frame: Frame,
    /// Passes over the training links.
    #[arg(long, default_value_t = 20)]
    epochs: u64,
    /// Time of the training instead of epochs, like 10m or 90s: loading, steps and scores count. The learning rate follows it,
    /// and a run that is continued gets what is left.
    #[arg(long, value_parser = humantime::parse_duration, conflicts_with = "epochs")]
    budget: Option<Duration>,
    /// Batch size [links; default: the paper's with --preset paper, else 64; 128 for polar_reg].
    #[arg(long)]
    batch: Option<usize>,
    /// Highest learning rate [default: the paper's; 2e-3 for polar_reg].
    #[arg(long)]
    lr: Option<f64>,
    /// Seed of initial weights, order, dropout and --limit.
    #[arg(long, default_value_t = 42)]
    seed: u64,
    /// Maps to choose the best weights by, out of the training maps: ids like 0-4,7, or count:N
    /// [default: the data set's].
    #[arg(long)]
    dev_maps: Option<DevelopmentMaps>,
    /// Development links scored each time, drawn by the seed; 0 takes all.
    #[arg(long, default_value_t = 10_000)]
    dev_limit: usize,
    /// Steps between two scores, beside the usual ones: more weights to choose the best from.
    #[arg(long)]
    score_every: Option<NonZeroU64>,
    /// Links to train on, drawn by the seed from all training maps [default: all].
    #[arg(long)]
    limit: Option<usize>,
    /// Train on each link four times an epoch: on its map and on the map's mirror images along x, y and both. For spectra
    /// of a uniform linear array, which follow without tracing.
    #[arg(long)]
    mirror: bool,
    /// Device to compute on.
    #[arg(long, value_parser = devices(), default_value_t = Device::Cpu)]
    device: Device,
    /// Numbers to compute with [default: mixed on a GPU, full on the processor].
    #[arg(long, value_parser = precisions())]
    precision: Option<Precision>,
    /// Weight of the absolute error beside the regularizer's score, for ms_areg and adv_mlp
    /// [default: 100, the paper's].
    #[arg(long)]
    l1_weight: Option<f64>,
    /// Initial weights of the backbone: torchvision's ResNet-18, or ViT-B/16 for vit_reg, or those of another model of the same preset, whose encoder is taken.
    #[arg(long)]
    pretrained: Option<PathBuf>,
    /// Initial weights of the whole model: its own of an earlier run, or for ms_areg those of ms_mlp, with whose predictions
    /// it then begins.
    #[arg(long, conflicts_with = "pretrained")]
    warm_start: Option<PathBuf>,
    /// Threads [default: all cores].
    #[arg(long)]
    threads: Option<usize>,
    /// Continue the run in --out.
    #[arg(long)]
    resume: bool,
    /// Folder of the run.
    #[arg(long)]
    out: PathBuf,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        xtask::use_threads(self.threads)?;
        ensure!(
            self.l1_weight.is_none() || self.model.is_adversarial(),
            "--l1-weight is for models with a regularizer, ms_areg and adv_mlp, not for {}",
            self.model
        );
        ensure!(
            self.image_size.is_none() || self.model.input() == InputKind::Images,
            "--image-size is for models of images, not for {}",
            self.model
        );
        ensure!(
            self.frame == Frame::default() || self.model.input() == InputKind::Images,
            "--frame is for models of images, not for {}",
            self.model
        );
        ensure!(
            self.limit != Some(0),
            "--limit 0 leaves no link to train on; without --limit all are taken"
        );
        let folder = RunFolder::create(&self.out)?;
        folder.check_for_new_run()?;
        let has_checkpoint = folder.checkpoint().is_file();
        ensure!(
            self.resume || !has_checkpoint,
            "'{}' holds a run already; continue it with --resume, or give another --out",
            self.out.display()
        );
        ensure!(
            !self.resume || has_checkpoint,
            "there is no run to continue in '{}'; start one without --resume",
            self.out.display()
        );
        let interrupted = interrupt_flag()?;
        let dataset = training::open(&self.data)?;
        let plan = self.plan(&dataset)?;
        let run = plan.prepare(&dataset, folder.clone(), self.resume);
        let made = run.and_then(|mut run| {
            let bar = run::Bar::begin(&plan, &run);
            let made = run.train(&Control {
                progress: &bar,
                cancel: interrupted,
                ..Control::default()
            });
            bar.end(made.is_ok());
            made.map(|()| run)
        });
        let run = made.map_err(|error| match interrupted.load(Ordering::Relaxed) {
            true => Error::new(error).context("the same command with --resume continues"),
            false => advised(error),
        })?;
        run::print_scores(&run, &folder)
    }

    fn plan(&self, dataset: &Dataset) -> Result<Training> {
        let usual = self.model.train_config(self.preset);
        let configuration = &dataset.manifest().configuration;
        Ok(Training {
            maps: self.tiles.open_for(self.maps.as_ref(), configuration)?,
            model: self.model,
            preset: self.preset,
            image_size: self.image_size.unwrap_or(usual_image_size(self.preset)),
            frame: self.frame,
            config: TrainConfig {
                epochs: self.epochs,
                budget_s: self.budget.map(|budget| budget.as_secs_f64()),
                batch: self.batch.unwrap_or(usual.batch),
                learning_rate: self.lr.unwrap_or(usual.learning_rate),
                seed: self.seed,
                l1_weight: self.l1_weight.unwrap_or(usual.l1_weight),
                precision: self.precision.unwrap_or(self.device.usual_precision()),
                ..usual
            },
            development_maps: self.dev_maps.clone().unwrap_or_default(),
            development_links: (self.dev_limit > 0).then_some(self.dev_limit),
            selection: Selection::default(),
            score_every: self.score_every,
            mirror: self.mirror,
            links: self.limit,
            device: self.device,
            initial: match (&self.pretrained, &self.warm_start) {
                (Some(path), _) => InitialWeights::Backbone(path.clone()),
                (None, Some(path)) => InitialWeights::Model(path.clone()),
                (None, None) => InitialWeights::Random,
            },
        })
    }
}

/// Names the option that helps against an error of the library, which does not know them.
fn advised(error: map2aps::Error) -> Error {
    let advice = match error.cause() {
        map2aps::Error::Training(
            TrainingError::NotATrainingMap { pool, .. } | TrainingError::NoDevelopmentMaps { pool },
        ) if pool.len() > 1 => "name development maps with --dev-maps",
        map2aps::Error::Mirror(_) => "train without --mirror",
        map2aps::Error::Map(MapError::NoScene(_)) => "--maps",
        _ => return error.into(),
    };
    Error::new(error).context(advice)
}
