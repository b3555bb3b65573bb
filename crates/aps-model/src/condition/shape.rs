//! Kinds and shapes of models' inputs.

use candle_core::{Result, bail};

/// Kind of input that a model takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InputKind {
    /// Condition images: [`ConditionImages`](super::ConditionImages).
    Images,
    /// Ways along rays around the receiver, made by whoever knows the scene: see [`PolarShape`].
    Polar,
}

/// Shape of a link's input, as far as the layers of a model depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InputShape {
    /// Condition images of any size, (links, 3, height, width).
    Images,
    /// Ways along rays.
    Polar(PolarShape),
}

/// Shape of ways along rays, (links, ways, [`per_way`](Self::per_way)): of each way its features, the number of the direction that it
/// arrives from, and that of its kind. Links of fewer ways than others end with ways of zeros.
///
/// Feature 0 is the share of the ray that the way arrives along, in \[0, 1\]; feature 1 is 1 for a way, and 0 for one of zeros.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PolarShape {
    /// Directions around the receiver.
    pub directions: usize,
    /// Kinds of ways.
    pub kinds: usize,
    /// Features of a way, three at least.
    pub features: usize,
}

impl PolarShape {
    /// Returns the length of the last axis: features, direction and kind.
    pub fn per_way(&self) -> usize {
        self.features + 2
    }
}

impl InputShape {
    /// Returns the kind of input that has this shape.
    pub fn kind(&self) -> InputKind {
        match self {
            Self::Images => InputKind::Images,
            Self::Polar(_) => InputKind::Polar,
        }
    }

    /// Returns the shape of ways along rays.
    pub(crate) fn polar(self) -> Result<PolarShape> {
        match self {
            Self::Polar(shape) if shape.directions * shape.kinds > 0 && shape.features > 2 => {
                Ok(shape)
            }
            Self::Images | Self::Polar(_) => {
                bail!("the model takes ways along rays, not {self:?}")
            }
        }
    }
}
