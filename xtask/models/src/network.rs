//! Models by name, and their weights.

use std::path::Path;

use anyhow::{Context, Result, bail};
use aps_model::candle_core::{DType, Device};
use aps_model::train::{Regularize, Trainees};
use aps_model::weights::{self, Label};
use aps_model::{Model, ModelKind, Parameters, Preset};

/// The networks of a training with first values from `seed`, or the backbone's from a file.
pub fn trainees(
    Label { kind, preset }: Label,
    seed: u64,
    pretrained: Option<&Path>,
    device: &Device,
) -> Result<Trainees> {
    let predictor = kind.build(preset, &Parameters::new(device, DType::F32, seed))?;
    let own = Parameters::new(device, DType::F32, seed.wrapping_add(1));
    let regularizer = kind.build_regularizer(preset, &own)?;
    if let Some(path) = pretrained {
        let report = weights::load_pretrained(path, predictor.parameters())
            .with_context(|| format!("--pretrained '{}'", path.display()))?;
        eprintln!("backbone from '{}': {report}", path.display());
    }
    Ok(Trainees {
        predictor,
        regularizer: regularizer.map(|network| Box::new(network) as Box<dyn Regularize>),
    })
}

/// Which model weights are of: what is asked for, or what the file says; both, if there, must agree.
pub fn label_of(path: &Path, kind: Option<ModelKind>, preset: Option<Preset>) -> Result<Label> {
    let place = path.display();
    let stored = weights::read_label(path).with_context(|| format!("weights '{place}'"))?;
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
    weights::load(path, model.parameters())
        .with_context(|| format!("'{}' as weights of {kind}, preset {preset}", path.display()))?;
    Ok(kind.build(preset, &model.parameters().frozen()?)?)
}

/// The image size a preset is meant for.
pub fn image_size(preset: Preset) -> usize {
    match preset {
        Preset::Paper => 256,
        Preset::Small => 64,
    }
}
