//! The spectra to score against: rows of a file, or labels of a data set made into targets.

use std::fmt;
use std::path::Path;

use aps_data::{Dataset, Part};
use aps_label::{MeanStd, Normalization, Protocol};
use aps_metrics::Shape;
use serde_json::{Value, json};

use super::{ArrayFile, Domain, ScoreError, links};
use crate::error::{At, Place, Result};
use crate::targets::{self, Target};

/// Source of the true spectra.
#[derive(Debug)]
#[non_exhaustive]
pub enum Truth {
    /// A file of spectra, compared as they are.
    File(ArrayFile),
    /// The labels of one part of a data set, made into targets.
    Dataset(Box<Labels>),
}

/// The labels of one part of a data set.
#[derive(Debug)]
pub struct Labels {
    dataset: Dataset,
    place: String,
    part: Part,
    domain: Domain,
    target: Target,
    /// The statistics of a normalised target.
    training: Option<MeanStd>,
}

impl Truth {
    /// The labels of one part of a data set; nothing but its manifest is read.
    ///
    /// # Errors
    /// A folder without a data set, one that stores no angle power spectra, and a part without maps.
    pub fn dataset(folder: &Path, part: Part, domain: Domain) -> Result<Self> {
        let dataset = Dataset::open(folder)?;
        let place = folder.display().to_string();
        dataset.aps_layout()?;
        targets::maps_of(&dataset, part)?;
        Ok(Truth::Dataset(Box::new(Labels {
            dataset,
            place,
            part,
            domain,
            target: Target::Linear,
            training: None,
        })))
    }

    /// The protocol the labels were made under, if that is known.
    pub fn own_protocol(&self) -> Option<Protocol> {
        match self {
            Truth::File(_) => None,
            Truth::Dataset(labels) => targets::protocol_of(&labels.dataset),
        }
    }

    /// Fixes the target of a data set's labels; for this the training maps are read once.
    ///
    /// # Errors
    /// Training maps that cannot be read or hold no label.
    pub(super) fn prepare(&mut self, protocol: Protocol) -> Result<()> {
        match self {
            Truth::Dataset(labels) if labels.domain == Domain::Normalised => {
                let train = targets::training_statistics(&labels.dataset);
                let train = train.at_file(Place::Dataset, Path::new(&labels.place))?;
                labels.target = Target::Normalised(Normalization::of(protocol, train));
                labels.training = Some(train);
                Ok(())
            }
            Truth::Dataset(_) | Truth::File(_) => Ok(()),
        }
    }

    /// Samples and bins.
    pub fn shape(&self) -> Shape {
        match self {
            Truth::File(file) => file.shape(),
            Truth::Dataset(labels) => labels.shape(),
        }
    }

    /// Hands over all rows in order, at most about `values` numbers at a time, with the map they
    /// belong to where it is known.
    pub(super) fn for_each_block(
        &mut self,
        values: usize,
        mut take: impl FnMut(&[f64], Option<u32>) -> Result<()>,
    ) -> Result<()> {
        let Shape { samples, bins } = self.shape();
        let block = (values / bins).max(1);
        match self {
            Truth::File(file) => {
                file.rewind()?;
                let mut rows = Vec::new();
                for start in (0..samples).step_by(block) {
                    file.read_rows(block.min(samples - start), &mut rows)?;
                    take(&rows, None)?;
                }
                Ok(())
            }
            Truth::Dataset(labels) => labels.for_each_block(block, |rows, id| take(rows, Some(id))),
        }
    }

    /// Form in which the labels of a data set are compared, and once they are scored, the statistics of a normalised
    /// target; `None` for a file.
    pub fn target(&self) -> Option<(Domain, Option<MeanStd>)> {
        match self {
            Truth::File(_) => None,
            Truth::Dataset(labels) => Some((labels.domain, labels.training)),
        }
    }

    /// Describes the source of the truth for the report.
    pub fn describe(&self) -> Value {
        match self {
            Truth::File(_) => json!({ "source": self.to_string() }),
            Truth::Dataset(labels) => json!({
                "source": self.to_string(),
                "maps": labels.maps(),
                "domain": labels.domain.name(),
                "training": labels.training,
            }),
        }
    }
}

/// `truth` and its place, for messages.
impl fmt::Display for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Truth::File(file) => write!(f, "truth '{}'", file.path().display()),
            Truth::Dataset(labels) => {
                write!(
                    f,
                    "truth '{}' (valid links of the {} maps {:?}, in order)",
                    labels.place,
                    labels.part.name(),
                    labels.maps()
                )
            }
        }
    }
}

impl Labels {
    fn maps(&self) -> &[u32] {
        self.dataset.manifest().split.maps(self.part)
    }

    /// Refuses a prediction that is of other links, as far as a file beside it tells.
    pub(super) fn check_links(&self, prediction: &Path) -> Result<()> {
        links::check_links(&self.dataset, self.part, prediction)
    }

    fn bins(&self) -> usize {
        let aps = self.dataset.manifest().layout.aps;
        aps.expect("checked when opened").axis.count
    }

    /// Reads the shape from the manifest, so that a prediction of another is refused before hours of reading.
    fn shape(&self) -> Shape {
        Shape {
            samples: targets::labelled_links(&self.dataset, self.maps()),
            bins: self.bins(),
        }
    }

    fn for_each_block(
        &self,
        block: usize,
        mut take: impl FnMut(&[f64], u32) -> Result<()>,
    ) -> Result<()> {
        let Shape { samples, bins } = self.shape();
        let (part, target) = (self.part, self.target);
        let damaged = || ScoreError::Damaged {
            folder: self.place.clone(),
            samples,
        };
        let mut left = samples;
        let found = targets::for_each_block(&self.dataset, part, target, block, |rows, id| {
            let links = rows.len() / bins;
            left = left.checked_sub(links).ok_or_else(damaged)?;
            take(rows, id)
        })?;
        match found == samples {
            true => Ok(()),
            false => Err(damaged().into()),
        }
    }
}
