//! Training examples: links and their target spectra.
//!
//! Training reads them through the trait [`Examples`], so that this crate knows no file format. The implementation
//! decides how they are kept: all in memory as f32 ([`Samples`], 720 bytes a link), or in a shorter form that is turned
//! into the target when a batch is put together.

mod mirrored;

use std::fmt::Debug;

use crate::condition::Link;
use crate::{ANGLE_BINS, Error, Result};
pub use mirrored::Mirrored;

/// A numbered set of links with target spectra. A number always gives the same link and target.
pub trait Examples: Debug + Send + Sync {
    /// Returns the number of examples.
    fn len(&self) -> usize;

    /// Returns true when there are no examples.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the link of an example below [`len`](Self::len).
    fn link(&self, example: usize) -> Link;

    /// Writes the normalised target of an example, [`ANGLE_BINS`] values. Called from a thread of its own, a batch ahead of
    /// the training step.
    fn write_target(&self, example: usize, target: &mut [f32]);
}

/// Examples in memory.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Samples {
    links: Vec<Link>,
    targets: Vec<f32>,
}

impl Samples {
    /// Links with their targets: shape (links, [`ANGLE_BINS`]), last axis fastest.
    ///
    /// # Errors
    /// [`Error::Samples`] when there are not [`ANGLE_BINS`] values a link, or one is not finite.
    pub fn new(links: Vec<Link>, targets: Vec<f32>) -> Result<Self> {
        if links.len().checked_mul(ANGLE_BINS) != Some(targets.len()) {
            let (values, links) = (targets.len(), links.len());
            return Err(Error::Samples(format!(
                "{values} target values for {links} links: there must be {ANGLE_BINS} a link"
            )));
        }
        if let Some(i) = targets.iter().position(|x| !x.is_finite()) {
            let (link, bin, value) = (i / ANGLE_BINS, i % ANGLE_BINS, targets[i]);
            return Err(Error::Samples(format!(
                "target of link {link} is {value} in bin {bin}: leave out what has no label"
            )));
        }
        Ok(Self { links, targets })
    }
}

impl Examples for Samples {
    fn len(&self) -> usize {
        self.links.len()
    }

    fn link(&self, example: usize) -> Link {
        self.links[example]
    }

    fn write_target(&self, example: usize, target: &mut [f32]) {
        target.copy_from_slice(&self.targets[example * ANGLE_BINS..][..ANGLE_BINS]);
    }
}
