//! `cargo xtask train`: a data set in, weights out.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use aps_model::condition::ConditionConfig;
use aps_model::train::{TrainConfig, Trainer};
use aps_model::weights::Label;
use aps_model::{ModelKind, Preset};

use crate::data::{self, DevMaps};
use crate::device::{Device, use_threads};
use crate::labels::Labels;
use crate::network;
use crate::run::{Progress, Run};
use crate::score::{self, Development};
use crate::settings::{RunFolder, Settings};

/// What the options' one line each leaves open.
const WHAT_IS_WRITTEN: &str = "\
What is written into --out:
  best.safetensors   weights of the epoch with the least error on the development maps: mean absolute error for
                     models trained on it (ms_areg, adv_mlp), mean squared error for the others
  last.safetensors   everything needed to continue (--resume), written after each epoch, each 1000 steps, on Ctrl-C
  config.json        every setting
  steps.csv          loss, gradient norms and learning rate of each step
  epochs.csv         mean loss of each epoch and all metrics on the development maps

A run that is stopped and continued writes the same bytes as one that is not, on a CPU with any number of threads.
Test maps are never looked at: score them with `predict --split test` and `metrics`.";

/// Train a model on a data set.
#[derive(Debug, clap::Args)]
#[command(after_long_help = WHAT_IS_WRITTEN)]
pub struct Args {
    /// Which model: ms_areg, ms_mlp, adv_mlp, resnet_mlp, radiounet, vit_reg or resnet_conv1d.
    #[arg(long)]
    model: ModelKind,
    /// Folder of the data set.
    #[arg(long)]
    data: PathBuf,
    /// Sizes of the model: paper, or small for a CPU.
    #[arg(long, default_value_t = Preset::Small)]
    preset: Preset,
    /// Rows and columns of condition images [pixels; default: 256 paper, 64 small].
    #[arg(long)]
    image_size: Option<usize>,
    /// Times each link is learnt from.
    #[arg(long, default_value_t = 20)]
    epochs: u64,
    /// Links a step [default: the paper's with --preset paper, else 64].
    #[arg(long)]
    batch: Option<usize>,
    /// Highest learning rate [default: the paper's].
    #[arg(long)]
    lr: Option<f64>,
    /// Seed of first weights, order, dropout and --limit.
    #[arg(long, default_value_t = 42)]
    seed: u64,
    /// Maps to choose the best weights by, out of the training maps: ids like 0-4,7, or count:N
    /// [default: the data set's].
    #[arg(long)]
    dev_maps: Option<DevMaps>,
    /// Development links scored each epoch, drawn by the seed; 0 takes all.
    #[arg(long, default_value_t = 10_000)]
    dev_limit: usize,
    /// Links to train on, drawn by the seed from all training maps [default: all].
    #[arg(long)]
    limit: Option<usize>,
    /// Where to compute.
    #[arg(long, value_enum, default_value_t = Device::Cpu)]
    device: Device,
    /// torchvision weights the backbone begins with: ResNet-18, or ViT-B/16 for vit_reg.
    #[arg(long)]
    pretrained: Option<PathBuf>,
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
        use_threads(self.threads)?;
        let folder = RunFolder::create(&self.out)?;
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
        let mut run = self.prepare(folder)?;
        run.go()
    }

    fn prepare(&self, folder: RunFolder) -> Result<Run> {
        let device = self.device.open()?;
        let dataset = data::open(&self.data)?;
        let (train_maps, dev_maps) =
            data::divide(&dataset.manifest().split, self.dev_maps.as_ref())?;
        let (protocol, training_statistics, normalization) = data::target(&dataset)?;
        let all = train_maps.iter().chain(&dev_maps).copied();
        let image_size = self.image_size.unwrap_or(network::image_size(self.preset));
        let (conditions, index_of) = data::conditions(&dataset, all, image_size, &device)?;
        let load = |maps: &[u32], limit| {
            Labels::load(&dataset, maps, &index_of, limit, self.seed, normalization)
        };
        let train = load(&train_maps, self.limit)?;
        let dev = load(&dev_maps, (self.dev_limit > 0).then_some(self.dev_limit))?;
        let counts = [train.rows().len(), dev.rows().len()];
        ensure!(
            counts[0] > 0,
            "the training maps {train_maps:?} have no link with a label"
        );
        ensure!(
            counts[1] > 0,
            "the development maps {dev_maps:?} have no link with a label"
        );

        let label = Label {
            kind: self.model,
            preset: self.preset,
        };
        let training = self.training();
        let settings = Settings {
            model: self.model.to_string(),
            preset: self.preset.to_string(),
            image_size,
            sigma_px: ConditionConfig::default().sigma_px,
            initial_weights: match &self.pretrained {
                None => "random".into(),
                Some(path) => path.display().to_string(),
            },
            device: self.device,
            data: self.data.clone(),
            data_configuration: dataset.manifest().configuration.clone(),
            protocol: protocol.to_string(),
            training_statistics,
            train_maps,
            dev_maps,
            train_links: counts[0],
            dev_links: counts[1],
            training: training.clone(),
        };
        let mean_spectrum = score::mean_spectrum(&train);
        let trainees = network::trainees(label, self.seed, self.pretrained.as_deref(), &device)?;
        let mut trainer = Trainer::new(trainees, conditions, train, training)?;
        let progress = match self.resume {
            true => serde_json::from_str(&trainer.resume(folder.checkpoint())?)
                .context("notes of the checkpoint")?,
            false => Progress::default(),
        };
        folder.write_settings(&settings)?;
        eprintln!(
            "{} ({}, {} weights), {} training links of {} maps, {} development links of {} maps, images {image_size} x {image_size}, {} steps of {} links",
            settings.model,
            settings.preset,
            settings.initial_weights,
            settings.train_links,
            settings.train_maps.len(),
            settings.dev_links,
            settings.dev_maps.len(),
            trainer.steps_total(),
            settings.training.batch.min(settings.train_links),
        );
        let development = Development::new(dev, protocol);
        Run::new(label, folder, trainer, progress, development, mean_spectrum)
    }

    fn training(&self) -> TrainConfig {
        let preset = match self.model.is_adversarial() {
            true => TrainConfig::adversarial(),
            false => TrainConfig::regression(),
        };
        let papers_batch = match self.model {
            ModelKind::RadioUnet => 256,
            _ => preset.batch,
        };
        let papers_rate = match self.model {
            ModelKind::VitReg => 1e-4,
            _ => preset.learning_rate,
        };
        TrainConfig {
            epochs: self.epochs,
            batch: self.batch.unwrap_or(match self.preset {
                Preset::Paper => papers_batch,
                Preset::Small => 64,
            }),
            learning_rate: self.lr.unwrap_or(papers_rate),
            seed: self.seed,
            ..preset
        }
    }
}
