//! Learning targets of a data set's labels, alike for whoever trains on them and whoever scores against them.

use anyhow::{Context, Result};
use aps_data::{Dataset, MapData, Part, Profile};
use aps_label::{MeanStd, Moments, Normalization, Protocol, relative_power};
use rayon::prelude::*;

/// The protocol the labels were made under, if that is known.
pub fn protocol_of(dataset: &Dataset) -> Option<Protocol> {
    let configuration = &dataset.manifest().configuration;
    configuration["label"]["protocol"].as_str()?.parse().ok()
}

/// A protocol's target, with the statistics of the training maps.
pub fn normalization(protocol: Protocol, train: MeanStd) -> Normalization {
    match protocol {
        Protocol::Released => Normalization::Released(train),
        _ => Normalization::Paper(train),
    }
}

/// Mean and deviation of linear relative power over all labels of the training maps, which are read once for it. The
/// same bits for any number of threads: [`Moments`] are exact sums.
///
/// # Panics
/// When the data set stores no angle power spectra.
pub fn training_statistics(dataset: &Dataset) -> Result<MeanStd> {
    let mut total = Moments::default();
    for map in dataset.maps_of(Part::Train) {
        let map = map?;
        let aps = spectra(&map);
        let links: Vec<usize> = map.valid_links().collect();
        let of_link = |row: &mut LabelRow, &link: &usize| -> Result<Moments> {
            row.load(aps, link);
            relative_power(&mut row.values)?;
            let mut moments = Moments::default();
            moments.add(&row.values)?;
            Ok(moments)
        };
        let of_map = links
            .par_iter()
            .map_init(|| LabelRow::new(aps), of_link)
            .try_reduce(Moments::default, |mut a, b| {
                a.merge(&b);
                Ok(a)
            });
        total.merge(&of_map.with_context(|| format!("map {}", map.id))?);
    }
    total
        .mean_std()
        .context("the data set has no label in its training maps to normalise by")
}

/// The spectra of a map.
///
/// # Panics
/// When the data set stores none.
pub fn spectra(map: &MapData) -> &Profile {
    map.aps.as_ref().expect("the layout stores them")
}

/// One label, in the two precisions it passes through.
pub struct LabelRow {
    stored: Vec<f32>,
    /// What was loaded last.
    pub values: Vec<f64>,
}

impl LabelRow {
    /// Room for a label.
    pub fn new(aps: &Profile) -> Self {
        LabelRow {
            stored: vec![0.0; aps.bins()],
            values: vec![0.0; aps.bins()],
        }
    }

    /// Loads a link's values relative to its maximum [dB].
    pub fn load(&mut self, aps: &Profile, link: usize) {
        aps.read_relative_db(link, &mut self.stored);
        for (value, &stored) in self.values.iter_mut().zip(&self.stored) {
            *value = f64::from(stored);
        }
    }
}
