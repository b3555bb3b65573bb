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

/// Shape of ways along rays: (links, directions, [`values`](Self::values)), the values of a direction being the features of each
/// way, one way after another; or of lists of the ways that there are, (links, ways of a list, [`listed`](Self::listed)), each its
/// features, the number of its direction and its number among the ways of a direction. Lists of fewer ways end with some whose
/// feature 1 is 0.
///
/// Feature 0 is the share of the ray that the way arrives along, in \[0, 1\]; feature 1 is 1 where there is such a way, and 0, as
/// all others, where there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PolarShape {
    /// Directions around the receiver.
    pub directions: usize,
    /// Ways a direction: one a kind.
    pub ways: usize,
    /// Features of a way, three at least.
    pub features: usize,
}

impl PolarShape {
    /// Returns the number of values of a direction.
    pub fn values(&self) -> usize {
        self.ways * self.features
    }

    /// Returns the length of a way in a list.
    pub fn listed(&self) -> usize {
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
            Self::Polar(shape) if shape.directions * shape.ways > 0 && shape.features > 2 => {
                Ok(shape)
            }
            other => bail!("the model takes ways along rays, not {other:?}"),
        }
    }
}
