//! Weights that come with this crate.

use std::path::Path;

use candle_nn::VarMap;

use super::source::Source;
use super::{Label, LoadReport, fill};
use crate::{ModelKind, Preset, Result};

/// Weights of a model that was trained before, with an account of it.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Shipped {
    /// Model and preset.
    pub label: Label,
    /// The file, as safetensors: matrices and kernels in half precision.
    pub bytes: &'static [u8],
    /// Settings of the training, as JSON: `config.json` of the run.
    pub settings: &'static str,
    /// Model card, as Markdown: data, settings, steps, machine, scores, and what the weights are not good for.
    pub card: &'static str,
}

macro_rules! shipped {
    ($kind:ident, $preset:ident, $folder:literal) => {
        Shipped {
            label: Label {
                kind: ModelKind::$kind,
                preset: Preset::$preset,
            },
            bytes: include_bytes!(concat!("../../shipped/", $folder, "/weights.safetensors")),
            settings: include_str!(concat!("../../shipped/", $folder, "/config.json")),
            card: include_str!(concat!("../../shipped/", $folder, "/README.md")),
        }
    };
}

/// Everything that is shipped.
const ALL: [Shipped; 2] = [
    shipped!(MsAreg, Small, "ms_areg"),
    shipped!(PolarReg, Small, "polar_reg"),
];

impl Shipped {
    /// Everything that is shipped, in the order in which the models are listed.
    pub fn all() -> impl Iterator<Item = Self> {
        ALL.into_iter()
    }

    /// The weights of a model, if some are shipped.
    ///
    /// ```
    /// use aps_model::ModelKind;
    /// use aps_model::weights::Shipped;
    ///
    /// assert!(Shipped::of(ModelKind::PolarReg).is_some());
    /// assert!(Shipped::of(ModelKind::VitReg).is_none());
    /// ```
    pub fn of(kind: ModelKind) -> Option<Self> {
        Self::all().find(|shipped| shipped.label.kind == kind)
    }

    /// Fills all tensors of the model.
    ///
    /// # Errors
    /// [`Error::WeightsMismatch`](crate::Error::WeightsMismatch) where these are tensors of another model.
    pub fn load(&self, parameters: &VarMap) -> Result<LoadReport> {
        let name = format!("shipped {}", self.label.kind);
        let source = Source::of_bytes(Path::new(&name), self.bytes.to_vec())?;
        fill(&source, parameters)
    }
}
