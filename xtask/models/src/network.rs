//! Models by name, and their weights.

use std::fmt;
use std::path::{Path, PathBuf};
use xtask::note;

use anyhow::{Context, Result, bail};
use aps_model::candle_core::{DType, Device};
use aps_model::train::{Regularize, Trainees};
use aps_model::weights::{self, Label, LoadReport};
use aps_model::{Error, Model, ModelKind, Parameters, Preset};

/// Initial weights of a training.
#[derive(Debug, Clone)]
pub enum Beginning {
    /// Drawn by the seed.
    Random,
    /// The backbone's from a file, the regularizer's too, the rest drawn.
    Backbone(PathBuf),
    /// The predictor's all from a file, as [`weights::warm_start`] takes them, and the regularizer's backbone.
    Model(PathBuf),
}

impl fmt::Display for Beginning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Random => f.write_str("random"),
            Self::Backbone(path) => write!(f, "backbone of {}", path.display()),
            Self::Model(path) => write!(f, "all of {}", path.display()),
        }
    }
}

/// The networks of a training with their first values.
pub fn trainees(
    Label { kind, preset }: Label,
    seed: u64,
    begin: &Beginning,
    device: &Device,
) -> Result<Trainees> {
    let predictor = kind.build(preset, &Parameters::new(device, DType::F32, seed))?;
    let own = Parameters::new(device, DType::F32, seed.wrapping_add(1));
    let regularizer = kind.build_regularizer(preset, &own)?;
    let load = |path: &Path| -> Result<LoadReport> {
        // In the paper all backbones begin pretrained.
        if let Some(regularizer) = &regularizer {
            weights::load_pretrained(path, regularizer.parameters())?;
        }
        Ok(match begin {
            Beginning::Model(_) => weights::warm_start(path, predictor.parameters())?,
            _ => weights::load_pretrained(path, predictor.parameters())?,
        })
    };
    if let Beginning::Backbone(path) | Beginning::Model(path) = begin {
        let report = load(path).with_context(|| format!("first weights: {begin}"))?;
        note!("first weights: {begin}: {report}");
    }
    Ok(Trainees {
        predictor,
        regularizer: regularizer.map(|network| Box::new(network) as Box<dyn Regularize>),
    })
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

/// A trained model, which answers and learns no more.
pub fn load(path: &Path, Label { kind, preset }: Label, device: &Device) -> Result<Box<dyn Model>> {
    let model = kind.build(preset, &Parameters::new(device, DType::F32, 0))?;
    let report = weights::load(path, model.parameters())
        .with_context(|| format!("'{}' as weights of {kind}, preset {preset}", path.display()))?;
    if !report.dropped.is_empty() {
        note!("weights '{}': {report}", path.display());
    }
    Ok(kind.build(preset, &model.parameters().frozen()?)?)
}

/// The image size a preset is meant for.
pub fn image_size(preset: Preset) -> usize {
    match preset {
        Preset::Paper => 256,
        Preset::Small => 64,
    }
}
