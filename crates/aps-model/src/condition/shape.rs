//! Kinds and shapes of models' inputs.

use candle_core::{Result, bail};

/// Kind of input that a model takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InputKind {
    /// Condition images: [`ConditionImages`](super::ConditionImages).
    Images,
    /// Fields of the geometry around the receiver, made by whoever knows the scene: see [`PolarShape`].
    Polar,
}

/// Shape of a link's input, as far as the layers of a model depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InputShape {
    /// Condition images of any size, (links, 3, height, width).
    Images,
    /// Polar fields.
    Polar(PolarShape),
}

/// Shape of polar fields: (links, [`rows`](Self::rows), directions), the rows of a link being those of each plane, one a range,
/// and after them one a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PolarShape {
    /// Planes over range and direction.
    pub planes: usize,
    /// Numbers a direction.
    pub numbers: usize,
    /// Ranges from the receiver.
    pub ranges: usize,
    /// Directions around the receiver.
    pub directions: usize,
}

impl PolarShape {
    /// Returns the number of rows of a link.
    pub fn rows(&self) -> usize {
        self.planes * self.ranges + self.numbers
    }

    /// Returns the number of values of a link.
    pub fn values(&self) -> usize {
        self.rows() * self.directions
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

    /// Returns the shape of polar fields.
    pub(crate) fn polar(self) -> Result<PolarShape> {
        match self {
            Self::Polar(shape) if shape.values() > 0 => Ok(shape),
            other => {
                bail!("the model takes polar fields with one direction at least, not {other:?}")
            }
        }
    }
}
