//! Models by name, and their weights.

use std::fmt;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use aps_model::candle_core::{DType, Device};
use aps_model::candle_nn::VarMap;
use aps_model::weights::{self, Label, LoadReport};
use aps_model::{Error, Model, ModelKind, Preset, Regularizer, frozen, seeded, trainable};
use xtask::note;

/// Initial weights of a training.
#[derive(Debug, Clone)]
pub enum InitialWeights {
    /// Drawn by the seed.
    Random,
    /// The backbone's from a file, the regularizer's too, the rest drawn.
    Backbone(PathBuf),
    /// The predictor's all from a file, as [`weights::warm_start`] takes them, and the regularizer's backbone.
    Model(PathBuf),
}

impl fmt::Display for InitialWeights {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Random => f.write_str("random"),
            Self::Backbone(path) => write!(f, "backbone of {}", path.display()),
            Self::Model(path) => write!(f, "all of {}", path.display()),
        }
    }
}

/// The networks of a training with their parameters.
pub struct Networks {
    /// The model and its tensors.
    pub model: (Box<dyn Model>, VarMap),
    /// The regularizer and its tensors, for the models that are trained against one.
    pub regularizer: Option<(Regularizer, VarMap)>,
}

impl Networks {
    /// Builds the networks of a training with their initial weights.
    pub fn new(
        Label { kind, preset }: Label,
        seed: u64,
        initial: &InitialWeights,
        device: &Device,
    ) -> Result<Self> {
        let (parameters, of_regularizer) = (VarMap::new(), VarMap::new());
        let model = kind.build(preset, seeded(&parameters, seed, DType::F32, device))?;
        let vb = seeded(&of_regularizer, seed.wrapping_add(1), DType::F32, device);
        let regularizer = kind.build_regularizer(preset, vb)?;
        let load = |path: &Path| -> Result<LoadReport> {
            // In the paper all backbones begin pretrained.
            if regularizer.is_some() {
                weights::load_pretrained(path, &of_regularizer)?;
            }
            Ok(match initial {
                InitialWeights::Model(_) => weights::warm_start(path, &parameters)?,
                _ => weights::load_pretrained(path, &parameters)?,
            })
        };
        if let InitialWeights::Backbone(path) | InitialWeights::Model(path) = initial {
            let report = load(path).with_context(|| format!("initial weights: {initial}"))?;
            note!("initial weights: {initial}: {report}");
        }
        Ok(Self {
            model: (model, parameters),
            regularizer: regularizer.map(|network| (network, of_regularizer)),
        })
    }
}

/// Finds the model and preset of weights: `kind` and `preset`, or those that the file names; where both are there they must
/// agree. A label that another program wrote into the file is ignored where `kind` is given.
pub fn label_of(path: &Path, kind: Option<ModelKind>, preset: Option<Preset>) -> Result<Label> {
    let place = path.display();
    let stored = match weights::read_label(path) {
        Err(Error::ForeignLabel { .. }) if kind.is_some() => None,
        Err(error @ Error::ForeignLabel { .. }) => {
            return Err(error).context("name the model with --model, and its --preset");
        }
        stored => stored.with_context(|| format!("weights '{place}'"))?,
    };
    let label = Label {
        kind: kind.or(stored.map(|s| s.kind)).with_context(|| {
            format!("'{place}' does not say which model it is of; give --model")
        })?,
        preset: preset.or(stored.map(|s| s.preset)).unwrap_or(Preset::Paper),
    };
    match stored.filter(|&stored| stored != label) {
        Some(Label { kind, preset }) => bail!(
            "'{place}' holds weights of {kind}, preset {preset}, not of {}, preset {}",
            label.kind,
            label.preset
        ),
        None => Ok(label),
    }
}

/// Loads a trained model for evaluation alone; returns its number of trainable parameters too.
pub fn load(path: &Path, label: Label, device: &Device) -> Result<(Box<dyn Model>, usize)> {
    let (Label { kind, preset }, parameters) = (label, VarMap::new());
    kind.build(preset, seeded(&parameters, 0, DType::F32, device))?;
    let report = weights::load(path, &parameters)
        .with_context(|| format!("'{}' as weights of {kind}, preset {preset}", path.display()))?;
    if !report.dropped.is_empty() {
        note!("weights '{}': {report}", path.display());
    }
    let counts = trainable(&parameters).into_iter();
    let count = counts.map(|(_, var)| var.elem_count()).sum();
    Ok((kind.build(preset, frozen(&parameters)?)?, count))
}

/// Returns the image size that a preset is meant for.
pub fn image_size(preset: Preset) -> usize {
    match preset {
        Preset::Paper => 256,
        Preset::Small => 64,
    }
}
