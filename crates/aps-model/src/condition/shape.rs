//! Kinds and shapes of models' inputs.

use candle_core::{Device, Result, Tensor, bail};

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

    /// Makes a tensor of the lists of some links, on the CPU; those of fewer ways than the longest end with zeros.
    ///
    /// # Errors
    /// Lists that are not of whole ways.
    pub fn lists(&self, lists: &[Vec<f32>]) -> Result<Tensor> {
        let is_whole = |list: &Vec<f32>| list.len().is_multiple_of(self.listed());
        if let Some(link) = lists.iter().position(|list| !is_whole(list)) {
            let (numbers, listed) = (lists[link].len(), self.listed());
            bail!("the list of link {link} has {numbers} numbers, a way {listed}");
        }
        let longest = lists.iter().map(Vec::len).max().unwrap_or(0);
        // A list of no way is one of zeros.
        let longest = longest.max(self.listed());
        let mut values = Vec::with_capacity(lists.len() * longest);
        for list in lists {
            values.extend_from_slice(list);
            values.resize(values.len() + longest - list.len(), 0.0);
        }
        let shape = (lists.len(), longest / self.listed(), self.listed());
        Tensor::from_vec(values, shape, &Device::Cpu)
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
