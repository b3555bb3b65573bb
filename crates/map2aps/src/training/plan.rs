//! The plan of a training, and its preparation.

use std::num::NonZeroU64;
use std::path::Path;
use std::time::{Duration, Instant};

use aps_data::Dataset;
use aps_label::{MeanStd, Protocol};
use aps_model::condition::{ConditionConfig, Frame, InputKind};
use aps_model::data;
use aps_model::train::{TrainConfig, Trainer};
use aps_model::weights::Label;
use aps_model::{LabelFacts, ModelKind, Preset};

use super::log::Log;
use super::maps::divide;
use super::mirror::mirrored;
use super::network::Networks;
use super::polar::label_facts;
use super::run::{Run, State};
use super::score::Development;
use super::{
    DevelopmentMaps, Device, InitialWeights, RunFolder, Selection, Settings, Trained,
    TrainingError, check, rows, usual_image_size,
};
use crate::control::Control;
use crate::error::{At, Place, Result};
use crate::examples::{Draw, Examples};
use crate::maps::MapSource;
use crate::{settings, targets};

/// Model, data and settings of a training.
#[derive(Debug, Clone)]
pub struct Training {
    /// The model to train.
    pub model: ModelKind,
    /// Its sizes.
    pub preset: Preset,
    /// Rows and columns of condition images \[pixels\].
    pub image_size: usize,
    /// Part of the plane that they show.
    pub frame: Frame,
    /// Settings of the optimization; its seed draws initial weights and links too.
    pub config: TrainConfig,
    /// Maps to choose the best weights by.
    pub development_maps: DevelopmentMaps,
    /// Development links scored each time, drawn by the seed; none for all.
    pub development_links: Option<usize>,
    /// Metric to choose the best weights by; a run is continued with the same.
    pub selection: Selection,
    /// Steps between two scores of the development links, beside the one at the end of each epoch, or those after fixed shares of
    /// a time budget.
    pub score_every: Option<NonZeroU64>,
    /// Links to train on, drawn by the seed; none for all.
    pub links: Option<usize>,
    /// If true, the model is trained on the mirror images of each link too.
    pub mirror: bool,
    /// Device to compute on.
    pub device: Device,
    /// Initial weights.
    pub initial: InitialWeights,
    /// Maps that the data set was made from, for a model that is given the geometry; synthetic ones need not be given.
    pub maps: Option<MapSource>,
}

impl Training {
    /// Plans a training with the paper's settings of the model, on all links, on the processor.
    pub fn new(model: ModelKind, preset: Preset) -> Self {
        Self {
            model,
            preset,
            image_size: usual_image_size(preset),
            frame: Frame::default(),
            config: model.train_config(preset),
            development_maps: DevelopmentMaps::default(),
            development_links: None,
            selection: Selection::default(),
            score_every: None,
            links: None,
            mirror: false,
            device: Device::default(),
            initial: InitialWeights::default(),
            maps: None,
        }
    }

    /// Trains, and returns the weights that did best on the development maps. A run that `folder` holds already is
    /// continued, to the same bytes.
    ///
    /// # Errors
    /// As [`Training::prepare`] and [`Run::train`], and a folder that holds weights without their checkpoint.
    pub fn run(&self, dataset: &Dataset, folder: &Path, control: &Control<'_>) -> Result<Trained> {
        let folder = RunFolder::create(folder)?;
        folder.check_for_new_run()?;
        let is_begun = folder.checkpoint().is_file();
        self.prepare(dataset, folder.clone(), is_begun)?
            .train(control)?;
        let (kind, preset) = (Some(self.model), Some(self.preset));
        let trained = Trained::load(&folder.best(), kind, preset, &self.device.open()?)?;
        Ok(trained.with_maps(self.maps.clone()))
    }

    /// Loads the examples and builds the networks; with `resume` they continue from the folder's checkpoint. A time budget
    /// ([`TrainConfig::budget_s`]) begins here.
    ///
    /// # Errors
    /// A data set without labels to learn, maps or links that are not there, initial weights or a checkpoint that do not fit,
    /// settings that cannot be used or are not those of the run, a folder that another run writes into, files that cannot be written.
    pub fn prepare(&self, dataset: &Dataset, folder: RunFolder, resume: bool) -> Result<Run> {
        let started = Instant::now();
        if resume && !folder.checkpoint().is_file() {
            return Err(TrainingError::NoRun(folder.path().into()).into());
        }
        let lock = folder.lock()?;
        let device = self.device.open()?;
        check(dataset)?;
        let orientations = settings::scene_of(&dataset.manifest().configuration)?.orientations;
        let split = &dataset.manifest().split;
        let (train_maps, dev_maps) = divide(split, &self.development_maps, orientations)?;
        let (protocol, training_statistics, target) = targets::learning_target(dataset)?;
        let seed = self.config.seed;
        let load = |part, maps: &[u32], limit: Option<usize>| -> Result<Examples> {
            let draw = limit.map(|links| Draw { links, seed });
            let examples = Examples::of_maps(dataset, maps, target, draw)?;
            match examples.list().is_empty() {
                true => Err(TrainingError::NoLinks {
                    part,
                    maps: maps.into(),
                }
                .into()),
                false => Ok(examples),
            }
        };
        let train = load("training", &train_maps, self.links)?;
        let development = load("development", &dev_maps, self.development_links)?;
        let images = ConditionConfig {
            image_size: self.image_size,
            frame: self.frame,
            ..ConditionConfig::default()
        };
        let chosen_by = self.selection.metric(self.model);
        let mut settings = Settings {
            model: self.model.to_string(),
            preset: self.preset.to_string(),
            image_size: self.image_size,
            sigma_px: images.sigma_px,
            frame: self.frame,
            initial_weights: self.initial.to_string(),
            device: self.device,
            data: dataset.root().into(),
            data_configuration: dataset.manifest().configuration.clone(),
            protocol,
            training_statistics,
            train_maps,
            dev_maps,
            train_links: train.list().len(),
            mirrored: self.mirror,
            dev_links: development.list().len(),
            chosen_by: Some(chosen_by.key().into()),
            training: Some(self.config.clone()),
        };
        if resume && let Some(stored) = Settings::beside(&folder.checkpoint())? {
            let differences = stored.differences(&settings)?;
            if !differences.is_empty() {
                let path = folder.settings();
                return Err(aps_data::Error::ConfigMismatch { path, differences }.into());
            }
            settings.initial_weights = stored.initial_weights;
        }
        let mean_target = train.mean_target();
        let maps = self.maps.as_ref();
        let development = Development {
            input: development.input(self.model, images, maps, &device)?,
            examples: development,
            protocol: protocol.into(),
        };
        let (train, input): (Box<dyn data::Examples>, _) = match self.mirror {
            false => {
                let input = train.input(self.model, images, maps, &device)?;
                (Box::new(train), input)
            }
            true => {
                let model = (self.model, images);
                mirrored(dataset, train, &development.examples, model, maps, &device)?
            }
        };
        let label = Label {
            kind: self.model,
            preset: self.preset,
        };
        let facts = self.label_facts(dataset, protocol, training_statistics)?;
        let networks = Networks::new(label, facts.as_ref(), seed, &self.initial, &device)?;
        let (model, parameters) = networks.model;
        let (loss, config) = (self.model.loss(), self.config.clone());
        let mut trainer = Trainer::new(model, &parameters, loss, input, train, config)?;
        if !device.is_cpu() {
            trainer = trainer.hold()?;
        }
        if let Some((regularizer, parameters)) = networks.regularizer {
            trainer = trainer.with_regularizer(regularizer, &parameters)?;
        }
        let state: State = match resume {
            true => {
                let notes = trainer.resume(folder.checkpoint())?;
                serde_json::from_str(&notes).at(Place::CheckpointNotes)?
            }
            false => State::default(),
        };
        if state.has_best() && !folder.best().is_file() {
            return Err(TrainingError::NoBest(folder.best()).into());
        }
        let (last_step, scored) = (trainer.steps_done().checked_sub(1), state.last_scored());
        let steps = Log::open(folder.steps(), rows::STEP_COLUMNS, last_step)?;
        let scores = Log::open(folder.scores(), &rows::score_columns(), scored)?;
        let times = Log::open(folder.times(), rows::TIME_COLUMNS, scored)?;
        folder.write_settings(&settings)?;
        if self.config.budget_s.is_none() {
            // A checkpoint keeps the time of a training that time ends.
            let spent = times.last().unwrap_or_default();
            trainer.spend(Duration::try_from_secs_f64(spent).unwrap_or_default());
        }
        trainer.spend(started.elapsed());
        Ok(Run {
            label,
            folder,
            settings,
            initial: networks.loaded,
            trainer,
            state,
            steps,
            scores,
            times,
            score_every: self.score_every,
            development,
            chosen_by,
            mean_target,
            _lock: lock,
        })
    }

    /// Collects the facts of the labels for a model that computes with their array; `None` for the others.
    fn label_facts(
        &self,
        dataset: &Dataset,
        protocol: Protocol,
        statistics: MeanStd,
    ) -> Result<Option<LabelFacts>> {
        let manifest = dataset.manifest();
        match (self.model.input(), manifest.layout.aps) {
            (InputKind::Polar, Some(aps)) => {
                let label = settings::label_of(&manifest.configuration);
                let label = label.map_err(TrainingError::NoArray)?;
                let angles_deg = aps.axis.values();
                let facts = label_facts(&label, angles_deg, protocol, statistics);
                Ok(Some(facts))
            }
            (InputKind::Images | InputKind::Polar, _) => Ok(None),
        }
    }
}
