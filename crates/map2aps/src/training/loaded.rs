//! Weights read into the tensors of their model.

use std::path::Path;

use aps_model::candle_core::{DType, Device};
use aps_model::candle_nn::VarMap;
use aps_model::weights::{self, Label, LoadReport, Shipped};
use aps_model::{Error as ModelError, ModelKind, Preset, seeded};

use super::folder::SETTINGS_FILE;
use super::input::shape_for;
use super::{Settings, TrainingError};
use crate::error::{At, Place, Result};

/// Tensors of a model, with what is known of them.
pub(super) struct Loaded {
    pub label: Label,
    pub parameters: VarMap,
    pub report: LoadReport,
    /// Settings of the training, if they are at hand.
    pub settings: Option<Settings>,
}

impl Loaded {
    /// Reads a file: see [`Trained::load`](super::Trained::load).
    pub fn file(
        path: &Path,
        kind: Option<ModelKind>,
        preset: Option<Preset>,
        device: &Device,
    ) -> Result<Self> {
        let label = label_of(path, kind, preset)?;
        let model = format!("{}, preset {}", label.kind, label.preset);
        let load = |parameters: &VarMap| weights::load(path, parameters);
        let filled = filled(label, load, device).at(Place::WeightsOf(path.into(), model))?;
        let settings = Settings::beside(path)?;
        let of = |s: &Settings| s.model == label.kind.name() && s.preset == label.preset.name();
        if let Some(other) = settings.as_ref().filter(|&settings| !of(settings)) {
            let foreign = TrainingError::ForeignSettings {
                stored: format!("{}, preset {}", other.model, other.preset),
                found: label,
            };
            return Err(foreign).at_file(Place::File, &path.with_file_name(SETTINGS_FILE));
        }
        Ok(Self { settings, ..filled })
    }

    /// Takes the weights that come with `aps-model`: see [`Trained::shipped`](super::Trained::shipped).
    pub fn shipped(kind: ModelKind, device: &Device) -> Result<Self> {
        let all = || Shipped::all().map(|shipped| shipped.label.kind);
        let shipped = Shipped::of(kind).ok_or_else(|| TrainingError::NotShipped {
            kind,
            shipped: all().collect(),
        })?;
        let load = |parameters: &VarMap| shipped.load(parameters);
        let filled = filled(shipped.label, load, device)?;
        Ok(Self {
            settings: Some(Settings::parse(shipped.settings)?),
            ..filled
        })
    }
}

/// Makes the tensors of a model and fills them.
fn filled(
    label: Label,
    load: impl FnOnce(&VarMap) -> Result<LoadReport, ModelError>,
    device: &Device,
) -> Result<Loaded> {
    let (kind, parameters) = (label.kind, VarMap::new());
    let vb = seeded(&parameters, 0, DType::F32, device);
    kind.build(label.preset, shape_for(kind), vb)?;
    let report = load(&parameters)?;
    Ok(Loaded {
        label,
        parameters,
        report,
        settings: None,
    })
}

/// Tells which model a file of weights is of, from the file and from what is known of it, which must agree.
fn label_of(path: &Path, kind: Option<ModelKind>, preset: Option<Preset>) -> Result<Label> {
    let stored = match weights::read_label(path) {
        Err(ModelError::ForeignLabel { .. }) if kind.is_some() => None,
        Err(error @ ModelError::ForeignLabel { .. }) => return Err(error.into()),
        stored => stored.at_file(Place::Weights, path)?,
    };
    let unnamed = || TrainingError::Unnamed(path.into());
    let expected = Label {
        kind: kind.or(stored.map(|s| s.kind)).ok_or_else(unnamed)?,
        preset: preset.or(stored.map(|s| s.preset)).unwrap_or(Preset::Paper),
    };
    match stored.filter(|&stored| stored != expected) {
        Some(found) => Err(TrainingError::OtherModel {
            path: path.into(),
            found,
            expected,
        }
        .into()),
        None => Ok(expected),
    }
}
