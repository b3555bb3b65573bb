//! Sizes of models by name.

use serde::{Deserialize, Serialize};

use crate::named::named;

/// Sizes of a model. Serialized: `paper` or `small`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// Sizes of the paper.
    #[default]
    Paper,
    /// The same architecture, narrower and shallower, to train on a CPU: half the width, RadioUNet a quarter, ViT-Reg with
    /// patches of 8 pixels of images of 64, width 192, depth 6, three heads.
    ///
    /// | model | trainable parameters |
    /// |---|---|
    /// | ms_areg, adv_mlp | 3,789,652, 3,444,564 |
    /// | their regularizer | 3,009,697 |
    /// | ms_mlp, resnet_mlp, resnet_conv1d | 3,715,796, 2,910,932, 4,721,921 |
    /// | radiounet | 1,969,428 |
    /// | vit_reg | 2,791,092 |
    ///
    /// Polar-Reg is the same in both: 3,841.
    Small,
}

named!(Preset, "preset": Paper = "paper", Small = "small");
