//! Models by name.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::models::{
    AdvMlp, MsAreg, MsMlp, RadioUnet, Regularizer, ResnetConv1d, ResnetMlp, VitReg, VitRegConfig,
};
use crate::{Error, Model, Parameters, Result};

/// The models of the benchmark. Serialized, one is its [`name`](ModelKind::name).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ModelKind {
    /// [`MsAreg`], the paper's reference.
    MsAreg,
    /// [`MsMlp`], an ablation.
    MsMlp,
    /// [`AdvMlp`], an ablation.
    AdvMlp,
    /// [`ResnetMlp`].
    ResnetMlp,
    /// [`RadioUnet`].
    #[serde(rename = "radiounet")]
    RadioUnet,
    /// [`VitReg`].
    VitReg,
    /// [`ResnetConv1d`].
    #[serde(rename = "resnet_conv1d")]
    ResnetConv1d,
}

impl ModelKind {
    /// Every model, in the order of this page.
    pub const ALL: [Self; 7] = [
        Self::MsAreg,
        Self::MsMlp,
        Self::AdvMlp,
        Self::ResnetMlp,
        Self::RadioUnet,
        Self::VitReg,
        Self::ResnetConv1d,
    ];

    /// Returns the name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::MsAreg => "ms_areg",
            Self::MsMlp => "ms_mlp",
            Self::AdvMlp => "adv_mlp",
            Self::ResnetMlp => "resnet_mlp",
            Self::RadioUnet => "radiounet",
            Self::VitReg => "vit_reg",
            Self::ResnetConv1d => "resnet_conv1d",
        }
    }

    /// Returns true when the model is trained against a [`Regularizer`].
    pub fn is_adversarial(self) -> bool {
        matches!(self, Self::MsAreg | Self::AdvMlp)
    }

    /// Builds the model with initial weights drawn from the seed of `parameters`, which must be empty.
    pub fn build(self, preset: Preset, parameters: &Parameters) -> Result<Box<dyn Model>> {
        let width = preset.width(self);
        Ok(match self {
            Self::MsAreg => Box::new(MsAreg::new(parameters, width)?),
            Self::MsMlp => Box::new(MsMlp::new(parameters, width)?),
            Self::AdvMlp => Box::new(AdvMlp::new(parameters, width)?),
            Self::ResnetMlp => Box::new(ResnetMlp::new(parameters, width, 0.1)?),
            Self::RadioUnet => Box::new(RadioUnet::new(parameters, width)?),
            Self::VitReg => Box::new(VitReg::new(parameters, preset.vit())?),
            Self::ResnetConv1d => Box::new(ResnetConv1d::new(parameters, width)?),
        })
    }

    /// Builds the regularizer to train the model against; `None` where it needs none. `parameters` must be empty: not the
    /// model's own.
    pub fn build_regularizer(
        self,
        preset: Preset,
        parameters: &Parameters,
    ) -> Result<Option<Regularizer>> {
        self.is_adversarial()
            .then(|| Regularizer::new(parameters, preset.width(self)))
            .transpose()
    }
}

impl fmt::Display for ModelKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for ModelKind {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        find("model", name, &Self::ALL)
    }
}

/// Sizes of a model. Serialized: `paper` or `small`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// Sizes of the paper.
    #[default]
    Paper,
    /// The same architecture, narrower and shallower, to train on a CPU.
    ///
    /// | model | trainable parameters |
    /// |---|---|
    /// | ms_areg, adv_mlp | 3,789,652, 3,444,564; half the width |
    /// | their regularizer | 3,009,697; half the width |
    /// | ms_mlp, resnet_mlp, resnet_conv1d | 3,715,796, 2,910,932, 4,721,921; half the width |
    /// | radiounet | 1,969,428; a quarter of the width |
    /// | vit_reg | 2,791,092; [`VitRegConfig::small`] |
    Small,
}

impl Preset {
    /// Every preset.
    pub const ALL: [Self; 2] = [Self::Paper, Self::Small];

    /// Returns the name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Small => "small",
        }
    }

    /// Returns the number of channels of the first stage of `kind`'s convolutions, to which all its other sizes but the
    /// spectrum's are proportional. It has no meaning for [`ModelKind::VitReg`].
    fn width(self, kind: ModelKind) -> usize {
        match (self, kind) {
            (Self::Paper, _) => 64,
            // Its first and last blocks work at full resolution.
            (Self::Small, ModelKind::RadioUnet) => 16,
            (Self::Small, _) => 32,
        }
    }

    fn vit(self) -> VitRegConfig {
        match self {
            Self::Paper => VitRegConfig::default(),
            Self::Small => VitRegConfig::small(),
        }
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Preset {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        find("preset", name, &Self::ALL)
    }
}

fn find<T: Copy + fmt::Display>(what: &'static str, name: &str, all: &[T]) -> Result<T> {
    all.iter()
        .copied()
        .find(|one| one.to_string() == name)
        .ok_or_else(|| Error::UnknownName {
            what,
            found: name.to_owned(),
            known: all.iter().map(T::to_string).collect::<Vec<_>>().join(", "),
        })
}
