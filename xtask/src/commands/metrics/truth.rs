//! The spectra to score against: rows of a file, or labels of a data set made into targets.

use std::fmt;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use aps_data::{Dataset, Part};
use aps_label::{MeanStd, Normalization, Protocol};
use aps_metrics::Shape;
use serde_json::{Value, json};

use super::Domain;
use super::rows::ArrayFile;
use crate::targets::{self, Target};

/// Source of the true spectra.
pub enum Truth {
    File(ArrayFile),
    Dataset(Box<Labels>),
}

/// The labels of one part of a data set.
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
    /// The labels of a data set; nothing but its manifest is read.
    pub fn dataset(root: &Path, part: Part, domain: Domain) -> Result<Self> {
        let dataset = Dataset::open(root)?;
        ensure!(
            dataset.manifest().layout.aps.is_some(),
            "data set '{}' stores no angle power spectra; make it with --store aps",
            root.display()
        );
        let place = root.display().to_string();
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
    pub fn prepare(&mut self, protocol: Protocol) -> Result<()> {
        match self {
            Truth::Dataset(labels) if labels.domain == Domain::Normalised => {
                let train = targets::training_statistics(&labels.dataset).with_context(|| {
                    format!(
                        "data set '{}' (--domain linear needs no statistics)",
                        labels.place
                    )
                })?;
                labels.target = Target::Normalised(Normalization::of(protocol, train));
                labels.training = Some(train);
                Ok(())
            }
            _ => Ok(()),
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
    pub fn for_each_block(
        &mut self,
        values: usize,
        mut take: impl FnMut(&[f64], Option<u32>) -> Result<()>,
    ) -> Result<()> {
        let Shape { samples, bins } = self.shape();
        let block = (values / bins).max(1);
        match self {
            Truth::File(file) => {
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

    /// Describes the form in which the labels of a data set are compared; `None` for a file.
    pub fn target(&self) -> Option<String> {
        let Truth::Dataset(labels) = self else {
            return None;
        };
        Some(match labels.training {
            None => "compared as linear power relative to the maximum".into(),
            Some(MeanStd { mean, std }) => {
                format!("compared as normalised target: training mean {mean:.6}, std {std:.6}")
            }
        })
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
                let (part, maps) = (labels.part, labels.maps());
                write!(
                    f,
                    "truth '{}' (valid links of {part:?} maps {maps:?}, in order)",
                    labels.place
                )
            }
        }
    }
}

impl Labels {
    fn maps(&self) -> &[u32] {
        self.dataset.manifest().split.maps(self.part)
    }

    fn bins(&self) -> usize {
        let aps = self.dataset.manifest().layout.aps;
        aps.expect("checked when opened").axis.count
    }

    /// From the manifest, so that a prediction of the wrong shape is told before hours of reading.
    fn shape(&self) -> Shape {
        let maps = self.maps();
        let entries = &self.dataset.manifest().maps;
        let samples = entries
            .iter()
            .filter(|entry| maps.contains(&entry.id))
            .map(|entry| entry.status.get("valid").copied().unwrap_or(0))
            .sum::<u64>();
        Shape {
            samples: samples as usize,
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
        let mut left = samples;
        let found = targets::for_each_block(&self.dataset, part, target, block, |rows, id| {
            let links = rows.len() / bins;
            ensure!(
                links <= left,
                "map {id} of '{}' has more valid links than the manifest says: it is damaged",
                self.place
            );
            left -= links;
            take(rows, id)
        })?;
        ensure!(
            found == samples,
            "'{}' has {found} valid links, its manifest says {samples}: it is damaged",
            self.place
        );
        Ok(())
    }
}
