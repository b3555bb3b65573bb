//! Weights in files.
//!
//! Weights are written as safetensors with a [`Label`] that names the model. Readable are safetensors and files of `torch.save`:
//! a state dict, or a checkpoint that holds one. In either, a model's tensors may lie below any prefix, as
//! `state_dict.` and `model.` of checkpoints, `module.` of `DataParallel` and `_orig_mod.` of `torch.compile`, and parts of a
//! model may be wrapped as well. Of several copies that of `p_state_dict`, `g_state_dict`, `model_state_dict`, `state_dict`,
//! `model_state`, `model` or `net` is meant, in this order; without such a name they are an error.
//!
//! A tensor that is missing, unknown, of another shape, not finite or a variance below 0 is an error, which names them, of more
//! than 24 the first, and the model keeps its values. What is left out is listed in the [`LoadReport`].
//!
//! ```
//! use aps_model::candle_core::{DType, Device};
//! use aps_model::weights::{Label, load, read_label, save};
//! use aps_model::candle_nn::VarMap;
//! use aps_model::condition::InputShape;
//! use aps_model::{ModelKind, Preset, seeded};
//!
//! let (kind, preset) = (ModelKind::MsMlp, Preset::Small);
//! let (trained, other) = (VarMap::new(), VarMap::new());
//! kind.build(preset, InputShape::Images, seeded(&trained, 1, DType::F32, &Device::Cpu))?;
//! kind.build(preset, InputShape::Images, seeded(&other, 2, DType::F32, &Device::Cpu))?;
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("weights.safetensors");
//! save(&path, &trained, Some(Label { kind, preset }))?;
//! assert_eq!(read_label(&path)?, Some(Label { kind, preset }));
//! assert_eq!(load(&path, &other)?.loaded, other.all_vars().len());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod matching;
mod names;
mod pickle;
mod pretrained;
mod report;
mod shipped;
mod source;
mod torch;
mod warm_start;

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use candle_core::Device;
use candle_nn::VarMap;

use crate::parameters::sorted;
use crate::replace::replace;
use crate::{Error, ModelKind, Preset, Result};
use matching::{assign, own_names};
pub(crate) use matching::{has_no_sign, is_finite};
pub use report::LoadReport;
pub use shipped::Shipped;
use source::Source;
pub use warm_start::warm_start;

/// Key of a [`Label`] in the metadata of safetensors. The value is model and preset, a blank between them.
const LABEL_KEY: &str = "model";

/// Model and preset that weights belong to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Label {
    /// The model.
    pub kind: ModelKind,
    /// Sizes of the model.
    pub preset: Preset,
}

/// Writes all tensors as safetensors, first beside `path`, then renamed: a file of that name is always whole.
///
/// # Errors
/// [`Error::WeightsIo`], and [`Error::Candle`] for tensors that cannot be copied from their device.
pub fn save(path: &Path, parameters: &VarMap, label: Option<Label>) -> Result<()> {
    let mut tensors = Vec::new();
    for (name, var) in sorted(parameters) {
        tensors.push((name, var.as_detached_tensor().to_device(&Device::Cpu)?));
    }
    // One entry: several would be written in another order each time.
    let words = label.map(|Label { kind, preset }| format!("{kind} {preset}"));
    let metadata = words.map(|words| HashMap::from([(LABEL_KEY.to_owned(), words)]));
    let bytes = safetensors::serialize(tensors, metadata);
    let bytes = bytes.map_err(|e| Error::weights_format(path, e))?;
    let written = replace(path, |partial| fs::write(partial, bytes));
    written.map_err(|e| Error::weights_io("write", path, e))
}

/// Reads the model and preset that a file's weights belong to; `None` if the file does not say: PyTorch's never do.
///
/// # Errors
/// [`Error::WeightsIo`], [`Error::WeightsFormat`], and [`Error::ForeignLabel`] where another program, or a later version,
/// wrote the label in other words.
pub fn read_label(path: &Path) -> Result<Option<Label>> {
    let source = Source::open(path)?;
    let Some(found) = source.metadata().remove(LABEL_KEY) else {
        return Ok(None);
    };
    let label = found.split_once(' ').and_then(|(kind, preset)| {
        let (kind, preset) = (kind.parse().ok()?, preset.parse().ok()?);
        Some(Label { kind, preset })
    });
    let path = path.to_owned();
    let found = found.chars().filter(|c| !c.is_control()).take(80).collect();
    let label = label.ok_or(Error::ForeignLabel { path, found })?;
    Ok(Some(label))
}

/// Fills all tensors from a file of [`save`] or `torch.save`.
///
/// # Errors
/// [`Error::WeightsIo`], [`Error::WeightsFormat`], and [`Error::WeightsMismatch`] with the tensors that do not fit;
/// nothing is changed then.
pub fn load(path: &Path, parameters: &VarMap) -> Result<LoadReport> {
    fill(&Source::open(path)?, parameters)
}

/// Fills all tensors from those of the same name.
fn fill(source: &Source, parameters: &VarMap) -> Result<LoadReport> {
    let wanted = sorted(parameters);
    let names = own_names(source, &wanted)?;
    assign(source, names, &wanted, None)
}

/// Fills the backbone from weights of torchvision, of any of its releases: of a `resnet18` for the ResNet models and the
/// regularizer, of a `vit_b_16` for ViT-Reg; or from weights of another model of the same preset, as MS-MLP's for MS-AReg, of
/// which the encoder is taken, the projections of a multi-scale one included where both have them. What else the file holds
/// (torchvision's classifier, the other model's decoder) is left out, which the report lists; what is not part of the
/// backbone keeps its values.
///
/// # Errors
/// As [`load`], and [`Error::NoBackbone`] for RadioUNet, which has none. torchvision's fit no preset but the paper's.
pub fn load_pretrained(path: &Path, parameters: &VarMap) -> Result<LoadReport> {
    let backbone = pretrained::Backbone::of(parameters).ok_or(Error::NoBackbone)?;
    let source = Source::open(path)?;
    let names = backbone.among(source.names());
    let names = names.map_err(|e| Error::weights_format(path, e))?;
    let mut wanted = sorted(parameters);
    wanted.retain(|(name, _)| backbone.needs(name) || names.found.contains_key(name));
    assign(&source, names, &wanted, None)
}
