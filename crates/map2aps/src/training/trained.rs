//! Trained models: weights read for prediction alone.

use std::path::Path;

use aps_data::Dataset;
use aps_label::{MeanStd, Normalization};
use aps_model::candle_core::{Device, Tensor};
use aps_model::condition::{ConditionConfig, InputKind, ModelInput};
use aps_model::train::predict;
use aps_model::weights::{Label, LoadReport};
use aps_model::{ANGLE_BINS, Model, ModelKind, Preset, frozen, trainable};

use super::input::shape_for;
use super::loaded::Loaded;
use super::{Settings, TrainingError, usual_image_size};
use crate::differences::Difference;
use crate::error::{At, Place, Result};
use crate::examples::Examples;
use crate::maps::MapSource;
use crate::targets::Target;

/// Links predicted at a time by [`Trained::predict`].
const BATCH: usize = 64;

/// A trained model, for prediction.
#[derive(Debug)]
pub struct Trained {
    label: Label,
    model: Box<dyn Model>,
    device: Device,
    parameters: usize,
    settings: Option<Settings>,
    maps: Option<MapSource>,
    /// Methods by which the targets of the training and those wanted are made, where these differ.
    target: Option<[Normalization; 2]>,
    report: LoadReport,
}

impl Trained {
    /// Reads weights, `.safetensors` or PyTorch's `.pt`. Model and preset are as the file says; where `kind` or `preset` is
    /// given too they must agree. A label that another program wrote into the file is ignored where `kind` is given.
    ///
    /// # Errors
    /// A file that cannot be read, does not say its model, or does not fit it.
    pub fn load(
        path: &Path,
        kind: Option<ModelKind>,
        preset: Option<Preset>,
        device: &Device,
    ) -> Result<Self> {
        Self::of(Loaded::file(path, kind, preset, device)?, device)
    }

    /// Takes the weights that come with `aps-model`.
    ///
    /// # Errors
    /// [`TrainingError::NotShipped`], and failures of the device.
    pub fn shipped(kind: ModelKind, device: &Device) -> Result<Self> {
        Self::of(Loaded::shipped(kind, device)?, device)
    }

    fn of(loaded: Loaded, device: &Device) -> Result<Self> {
        let counts = trainable(&loaded.parameters).into_iter();
        let Label { kind, preset } = loaded.label;
        Ok(Self {
            label: loaded.label,
            model: kind.build(preset, shape_for(kind), frozen(&loaded.parameters)?)?,
            device: device.clone(),
            parameters: counts.map(|(_, var)| var.elem_count()).sum(),
            settings: loaded.settings,
            maps: None,
            target: None,
            report: loaded.report,
        })
    }

    /// Gives the maps that data sets were made from, which a model that is given the geometry needs unless they are synthetic.
    #[must_use]
    pub fn with_maps(self, maps: Option<MapSource>) -> Self {
        Self { maps, ..self }
    }

    /// Predicts targets that are made by another method than those of the training, as of a data set with other statistics.
    /// Nothing changes where the settings of the training are not known, or its targets do not tell their power.
    #[must_use]
    pub fn for_targets(self, wanted: Target) -> Self {
        let Target::Normalised(wanted) = wanted else {
            return self;
        };
        let own = self.settings.as_ref().map(Settings::normalization);
        let differ = |&own: &Normalization| own != wanted;
        let target = own.filter(differ).map(|own| [own, wanted]);
        Self { target, ..self }
    }

    /// Compares the labels that the model learnt with those of a data set, and returns the differences with which predictions are
    /// possible but hardly good: of limits, material, carrier and sampling rate. None where the settings of the training are not
    /// known.
    ///
    /// # Errors
    /// [`TrainingError::OtherLabels`] where the same spectrum means something else: for another protocol or array.
    pub fn differences(&self, dataset: &Dataset) -> Result<Vec<Difference>> {
        let Some(settings) = &self.settings else {
            return Ok(Vec::new());
        };
        let found = &dataset.manifest().configuration;
        let all = Difference::all(settings.protocol, &settings.data_configuration, found);
        match all.iter().find(|difference| difference.is_of_meaning()) {
            Some(difference) => Err(TrainingError::OtherLabels {
                model: self.label.kind,
                difference: difference.clone(),
            })
            .at(Place::Dataset(dataset.root().into())),
            None => Ok(all),
        }
    }

    /// The model and its sizes.
    pub fn label(&self) -> Label {
        self.label
    }

    /// The model itself, its parameters frozen.
    pub fn model(&self) -> &dyn Model {
        &*self.model
    }

    /// Number of trainable parameters.
    pub fn parameters(&self) -> usize {
        self.parameters
    }

    /// Settings of the training, if the weights lie in the folder of a run.
    pub fn settings(&self) -> Option<&Settings> {
        self.settings.as_ref()
    }

    /// Account of the tensors that were read.
    pub fn report(&self) -> &LoadReport {
        &self.report
    }

    /// Condition images that the model was trained on; where that is not known, of the size that its preset is meant for.
    pub fn images(&self) -> ConditionConfig {
        match &self.settings {
            None => ConditionConfig {
                image_size: usual_image_size(self.label.preset),
                ..ConditionConfig::default()
            },
            Some(settings) => ConditionConfig {
                image_size: settings.image_size,
                sigma_px: settings.sigma_px,
                frame: settings.frame,
            },
        }
    }

    /// Rows and columns of condition images that are assumed, since no settings of the training tell them; `None` where they are known,
    /// and for a model that takes no images.
    pub fn assumed_image_size(&self) -> Option<usize> {
        let is_assumed = self.settings.is_none() && self.label.kind.input() == InputKind::Images;
        is_assumed.then(|| self.images().image_size)
    }

    /// Prepares the input of the model for some links.
    ///
    /// # Errors
    /// As [`Examples::input`].
    pub fn input(
        &self,
        examples: &Examples,
        images: ConditionConfig,
    ) -> Result<Box<dyn ModelInput>> {
        let (kind, maps) = (self.label.kind, self.maps.as_ref());
        examples.input(kind, images, maps, &self.device)
    }

    /// Predicts the normalised spectra of all examples; shape (examples, [`ANGLE_BINS`]).
    ///
    /// # Errors
    /// A prediction that is not finite, and failures of the device.
    pub fn predict(&self, examples: &Examples) -> Result<Vec<f32>> {
        let input = self.input(examples, self.images())?;
        let mut all = Vec::with_capacity(examples.list().len() * ANGLE_BINS);
        self.predict_batches(&*input, examples, BATCH, |spectra| {
            all.extend_from_slice(spectra);
            Ok(())
        })?;
        Ok(all)
    }

    /// Predicts the spectra of examples, `batch` at a time, and hands them over in order; `input` is
    /// [that](Trained::input) of these examples.
    ///
    /// # Errors
    /// As [`Trained::predict`], and whatever `take` returns.
    pub fn predict_batches(
        &self,
        input: &dyn ModelInput,
        examples: &Examples,
        batch: usize,
        mut take: impl FnMut(&[f32]) -> Result<()>,
    ) -> Result<()> {
        let take = |_, spectra: &[f32]| match self.target {
            Some([Normalization::Paper(own), wanted]) => take(&converted(spectra, own, wanted)?),
            Some([Normalization::Released(_), _]) | None => take(spectra),
        };
        predict(self.model(), input, examples.links(), batch, take)
    }

    /// Predicts the spectra of an input.
    pub(super) fn forward(&self, input: &Tensor) -> Result<Vec<f32>> {
        let spectra = self.model.forward_t(input, false)?.flatten_all()?;
        let spectra: Vec<f32> = spectra.to_vec1()?;
        match spectra.iter().position(|x| !x.is_finite()) {
            Some(bad) => Err(TrainingError::NotFinite(bad / ANGLE_BINS).into()),
            None => Ok(spectra),
        }
    }
}

/// Targets made by the paper's method with some statistics as those of another method.
fn converted(spectra: &[f32], own: MeanStd, wanted: Normalization) -> Result<Vec<f32>> {
    let mut all = Vec::with_capacity(spectra.len());
    for spectrum in spectra.chunks(ANGLE_BINS) {
        let power = spectrum.iter().map(|&x| f64::from(x) * own.std + own.mean);
        let mut values: Vec<f64> = power.collect();
        wanted.apply_to_power(&mut values)?;
        all.extend(values.iter().map(|&x| x as f32));
    }
    Ok(all)
}
