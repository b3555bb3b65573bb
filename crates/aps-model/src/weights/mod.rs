//! Weights in files.
//!
//! Written are safetensors, with a [`Label`] that says which model they are of. Read are safetensors and what `torch.save`
//! writes: a state dict, or a checkpoint that holds one under `p_state_dict`, `g_state_dict`, `model_state_dict` or
//! `state_dict`; names may all begin with `module.`, as `DataParallel` leaves them.
//!
//! A tensor that is missing, unknown, of another shape or not finite is an error, which lists all of them, and the model
//! keeps its values. What is left out on purpose is listed in the [`LoadReport`].
//!
//! ```
//! use aps_model::candle_core::{DType, Device};
//! use aps_model::weights::{Label, load, read_label, save};
//! use aps_model::{ModelKind, Parameters, Preset};
//!
//! let (kind, preset) = (ModelKind::MsMlp, Preset::Small);
//! let [trained, other] = [1, 2].map(|seed| Parameters::new(&Device::Cpu, DType::F32, seed));
//! kind.build(preset, &trained)?;
//! kind.build(preset, &other)?;
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("weights.safetensors");
//! save(&path, &trained, Some(Label { kind, preset }))?;
//! assert_eq!(read_label(&path)?, Some(Label { kind, preset }));
//! assert_eq!(load(&path, &other)?.loaded, other.all().len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod matching;
mod pickle;
mod pretrained;
mod source;
mod torch;
mod warm_start;

use std::collections::HashMap;
use std::fmt;
use std::fs;
use std::path::Path;

use candle_core::Device;
use serde::{Deserialize, Serialize};

use crate::{Error, ModelKind, Parameters, Preset, Result};
use matching::assign;
use source::Source;
pub use warm_start::warm_start;

/// Where the metadata of safetensors hold a [`Label`]: model and preset, a blank between them.
const LABEL_KEY: &str = "model";

/// Which model weights are of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Label {
    /// The model.
    pub kind: ModelKind,
    /// Its sizes.
    pub preset: Preset,
}

/// What loading did besides filling every tensor from the file.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LoadReport {
    /// Tensors filled.
    pub loaded: usize,
    /// Tensors of the file that are left out on purpose: the classifier of a pretrained backbone.
    pub dropped: Vec<String>,
    /// Counters (`num_batches_tracked`) the file lacks, as those of old PyTorch do. They are 0; no output depends on them.
    pub zeroed: Vec<String>,
    /// Tensors that keep their values, as the file has none for them: the noise input, in a [`warm_start`].
    pub kept: Vec<String>,
}

impl fmt::Display for LoadReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} tensors loaded", self.loaded)?;
        if !self.dropped.is_empty() {
            write!(f, "; left out: {}", self.dropped.join(", "))?;
        }
        if !self.kept.is_empty() {
            write!(f, "; kept: {}", self.kept.join(", "))?;
        }
        if !self.zeroed.is_empty() {
            write!(
                f,
                "; {} counters not in the file begin at 0",
                self.zeroed.len()
            )?;
        }
        Ok(())
    }
}

/// Writes all tensors as safetensors, first beside `path`, then renamed: a file of that name is always whole.
///
/// # Errors
/// [`Error::WeightsIo`], and [`Error::Candle`] for tensors that cannot be copied from their device.
pub fn save(path: &Path, parameters: &Parameters, label: Option<Label>) -> Result<()> {
    let mut tensors = Vec::new();
    for (name, parameter) in parameters.all() {
        let tensor = parameter.var.as_detached_tensor().to_device(&Device::Cpu)?;
        tensors.push((name, tensor));
    }
    // One entry: several would be written in another order each time.
    let metadata = label.map(|Label { kind, preset }| {
        HashMap::from([(LABEL_KEY.to_owned(), format!("{kind} {preset}"))])
    });
    let bytes =
        safetensors::serialize(tensors, metadata).map_err(|e| Error::weights_format(path, e))?;
    let mut partial = path.as_os_str().to_owned();
    partial.push(".partial");
    fs::write(&partial, bytes).map_err(|e| Error::weights_io("write", Path::new(&partial), e))?;
    fs::rename(&partial, path).map_err(|e| Error::weights_io("rename to", path, e))
}

/// Which model the weights in a file are of; `None` if it does not say: PyTorch's files never do.
///
/// # Errors
/// [`Error::WeightsIo`], [`Error::WeightsFormat`], and [`Error::UnknownName`] for a label of a later version.
pub fn read_label(path: &Path) -> Result<Option<Label>> {
    let source = Source::open(path)?;
    let metadata = source.metadata();
    match metadata
        .get(LABEL_KEY)
        .and_then(|text| text.split_once(' '))
    {
        Some((kind, preset)) => Ok(Some(Label {
            kind: kind.parse()?,
            preset: preset.parse()?,
        })),
        None => Ok(None),
    }
}

/// Fills all tensors from a file of [`save`] or `torch.save`.
///
/// # Errors
/// [`Error::WeightsIo`], [`Error::WeightsFormat`], and [`Error::WeightsMismatch`] with every tensor that does not fit;
/// nothing is changed then. [`Error::Frozen`] for [frozen](Parameters::frozen) parameters.
pub fn load(path: &Path, parameters: &Parameters) -> Result<LoadReport> {
    check_changeable(path, parameters)?;
    let source = Source::open(path)?;
    assign(path, &source, own_names(&source), &parameters.all(), None)
}

/// Fills the backbone from weights of torchvision: of a `resnet18` for the ResNet models and the regularizer, of a
/// `vit_b_16` for ViT-Reg; or from weights of another model of the same preset, as MS-MLP's for MS-AReg, of which the encoder
/// is taken, the projections of a multi-scale one included where both have them. What else the file holds (torchvision's
/// classifier, the other model's decoder) is left out, which the report lists; what is not part of the backbone keeps its
/// values.
///
/// # Errors
/// As [`load`]; [`Error::NoBackbone`] for RadioUNet, which has none. torchvision's fit no preset but the paper's.
pub fn load_pretrained(path: &Path, parameters: &Parameters) -> Result<LoadReport> {
    check_changeable(path, parameters)?;
    let backbone = pretrained::Backbone::of(parameters).ok_or(Error::NoBackbone)?;
    let source = Source::open(path)?;
    let adopts = pretrained::is_of_a_model(source.names());
    let mut found = Vec::new();
    let mut dropped = Vec::new();
    for name in source.names() {
        let renamed = match adopts {
            true => backbone.adopt(name),
            false => backbone.rename(name),
        };
        match renamed {
            Some(renamed) => found.push((renamed, name.to_owned())),
            None => dropped.push(name.to_owned()),
        }
    }
    let mut wanted = parameters.all();
    wanted.retain(|(name, _)| backbone.contains(name) || found.iter().any(|(f, _)| f == name));
    let report = assign(path, &source, found, &wanted, None)?;
    Ok(LoadReport { dropped, ..report })
}

/// Every tensor of the file, meant for the model's of the same name.
fn own_names(source: &Source) -> Vec<(String, String)> {
    let names = source.names().map(str::to_owned);
    names.map(|name| (name.clone(), name)).collect()
}

fn check_changeable(path: &Path, parameters: &Parameters) -> Result<()> {
    match parameters.is_frozen() {
        true => Err(Error::Frozen { path: path.into() }),
        false => Ok(()),
    }
}
