//! Labelled links as models learn from them: condition images and targets.

use aps_data::{ConditionConfig, ConditionImages, Dataset, Part, Samples};
use aps_label::{Normalization, Protocol};

use crate::error::{At, Place, Result};
use crate::scores::{Domain, ScoreError};
use crate::targets::{self, Target};

/// A labelled link of a data set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Example {
    /// Id of its map.
    pub map: u32,
    /// Row of the link in the map.
    pub link: usize,
    /// Place of the transmitter \[m\].
    pub tx_m: [f64; 2],
    /// Place of the receiver \[m\].
    pub rx_m: [f64; 2],
}

/// The labelled links of one part of a data set, in the order in which predictions are scored: maps ascending, links in
/// the order of their rows. Labels are held as they are stored, and made into targets when they are asked for.
#[derive(Debug, Clone)]
pub struct Examples {
    list: Vec<Example>,
    /// Image painter of each map, by ascending id.
    images: Vec<(u32, ConditionImages)>,
    db: Samples,
    bins: usize,
    target: Target,
}

impl Examples {
    /// Loads the examples of a part, with targets as [`Scoring`](crate::Scoring) compares them: for normalised ones, the
    /// training maps are read once more.
    ///
    /// # Errors
    /// A data set that stores no angle power spectra, cannot be read, or has nothing to normalise by.
    pub fn load(dataset: &Dataset, part: Part, domain: Domain) -> Result<Self> {
        let aps = dataset.manifest().layout.aps.ok_or(ScoreError::NoSpectra)?;
        let target = match domain {
            Domain::Linear => Target::Linear,
            Domain::Normalised => {
                let protocol = targets::protocol_of(dataset).unwrap_or(Protocol::Released);
                let train = targets::training_statistics(dataset)?;
                Target::Normalised(Normalization::of(protocol, train))
            }
        };
        let bins = aps.axis.count;
        let mut examples = Self {
            list: Vec::new(),
            images: Vec::new(),
            db: Samples::with_capacity(aps.dtype, 0),
            bins,
            target,
        };
        for map in dataset.maps_of(part) {
            let map = map?;
            let images = ConditionImages::new(&map.buildings, ConditionConfig::default());
            examples.images.push((map.id, images));
            for link in map.valid_links() {
                let (tx_m, rx_m) = map.ends_m(link);
                let samples = targets::spectra(&map).samples();
                examples.db.append(samples, link * bins..(link + 1) * bins);
                examples.list.push(Example {
                    map: map.id,
                    link,
                    tx_m,
                    rx_m,
                });
            }
        }
        Ok(examples)
    }

    /// The links.
    pub fn list(&self) -> &[Example] {
        &self.list
    }

    /// Length of a target.
    pub fn bins(&self) -> usize {
        self.bins
    }

    /// Length of a condition image: 3 planes of the size of the map's image.
    pub fn image_len(&self) -> usize {
        let first = self.images.first();
        first.map_or(0, |(_, images)| images.image_len())
    }

    /// Writes the target of an example into a row of [`Examples::bins`] values.
    ///
    /// # Errors
    /// A label that cannot be normalised.
    ///
    /// # Panics
    /// When there is no such example.
    pub fn write_target(&self, example: usize, row: &mut [f64]) -> Result<()> {
        let written = self.target.write(&self.db, example, row);
        written.at(Place::Link(self.list[example].link))
    }

    /// The targets of all examples; shape (examples, bins).
    ///
    /// # Errors
    /// A label that cannot be normalised.
    pub fn targets(&self) -> Result<Vec<f32>> {
        let mut targets = Vec::with_capacity(self.list.len() * self.bins);
        let mut row = vec![0.0; self.bins];
        for example in 0..self.list.len() {
            self.write_target(example, &mut row)?;
            targets.extend(row.iter().map(|&value| value as f32));
        }
        Ok(targets)
    }

    /// Writes the condition image of an example, of [`Examples::image_len`] values: buildings, transmitter, receiver.
    ///
    /// # Panics
    /// When there is no such example, or `image` has another length.
    pub fn write_condition(&self, example: usize, image: &mut [f32]) {
        let Example {
            map, tx_m, rx_m, ..
        } = self.list[example];
        let place = self.images.binary_search_by_key(&map, |(id, _)| *id);
        let (_, images) = &self.images[place.expect("the map was loaded")];
        images.write(tx_m, rx_m, image);
    }
}
