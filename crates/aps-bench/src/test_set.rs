//! The links everything is scored on.

use aps_data::{Dataset, Part};
use aps_label::{Normalization, Protocol};
use aps_metrics::{Metric, ScoredSample, spectrum_peaks};
use aps_model::ANGLE_BINS;
use aps_report::benchmark::{ScoreTable, TestLink};
use map2aps::targets;
use map2aps::{Draw, Example, Examples};
use rayon::prelude::*;

use crate::error::{Error, Result};

/// Labelled links of the test maps, or of the maps of another part.
#[derive(Debug)]
pub struct TestSet {
    /// The links and their labels.
    pub examples: Examples,
    maps: Vec<u32>,
    /// Method by which labels are made into targets.
    pub normalization: Normalization,
    /// Definition of the labels.
    pub protocol: Protocol,
    /// Number of labelled links of these maps, from which the scored ones are drawn.
    labelled: usize,
    /// Links of the test maps without a label.
    pub invalid: u64,
}

impl TestSet {
    /// The links of a part of a data set: all, or `limit` of them drawn by `seed`.
    pub fn load(dataset: &Dataset, part: Part, limit: Option<usize>, seed: u64) -> Result<Self> {
        let maps = dataset.manifest().split.maps(part).to_vec();
        let (protocol, train, target) = targets::learning_target(dataset)?;
        let draw = limit.map(|links| Draw { links, seed });
        let examples = Examples::of_maps(dataset, &maps, target, draw)?;
        if examples.list().is_empty() {
            return Err(no_links("chosen", &maps));
        }
        let labelled = targets::labelled_links(dataset, &maps);
        let entries = dataset.manifest().maps.iter();
        let of_test = entries.filter(|entry| maps.contains(&entry.id));
        let all: u64 = of_test.flat_map(|entry| entry.status.values()).sum();
        Ok(Self {
            examples,
            normalization: Normalization::of(protocol, train),
            protocol,
            labelled,
            invalid: all - labelled as u64,
            maps,
        })
    }

    /// Number of links.
    pub fn len(&self) -> usize {
        self.examples.list().len()
    }

    /// Chooses the rows of the scored links from predictions for all labelled links of the test maps.
    pub fn choose(&self, dataset: &Dataset, predicted: Vec<f32>) -> Result<Vec<f32>> {
        let rows = predicted.len() / ANGLE_BINS;
        if rows != self.labelled {
            let (maps, links) = (&self.maps, self.labelled);
            return Err(Error::Scores(format!(
                "it holds {rows} spectra; the test maps {maps:?} have {links} links with a label"
            )));
        }
        if rows == self.len() {
            return Ok(predicted);
        }
        let mut chosen = Vec::with_capacity(self.len() * ANGLE_BINS);
        let mut wanted = self.examples.list().iter().peekable();
        let mut row = 0;
        for &id in &self.maps {
            for link in dataset.map(id)?.valid_links() {
                let is_it = |of: &&Example| of.map == id && of.link == link;
                if wanted.next_if(is_it).is_some() {
                    chosen.extend_from_slice(&predicted[row * ANGLE_BINS..][..ANGLE_BINS]);
                }
                row += 1;
            }
        }
        Ok(chosen)
    }

    /// Scores of predictions, shape (links, bins), under a protocol.
    pub fn score(&self, predicted: &[f32], protocol: aps_metrics::Protocol) -> Result<ScoreTable> {
        let evaluation = self.examples.evaluate(predicted, protocol)?;
        if let Some(bad) = evaluation.rejected().first() {
            return Err(Error::Scores(format!(
                "the prediction of link {} cannot be scored: {}",
                bad.sample, bad.defect
            )));
        }
        let range = evaluation.truth_range().expect("there is a scored link");
        let row = |sample: &ScoredSample| Metric::ALL.map(|m| m.of(&sample.scores, range));
        let rows: Vec<_> = evaluation.scored().iter().map(row).collect();
        Ok(ScoreTable::of_rows(&rows)?)
    }

    /// Facts about each link for the report.
    pub fn links(&self, line_of_sight: &[bool]) -> Result<Vec<TestLink>> {
        let definition = aps_metrics::Protocol::Paper.definition();
        let describe = |i: usize| -> Result<TestLink> {
            let example = self.examples.list()[i];
            let peaks = spectrum_peaks(&self.examples.target(i), &definition)?;
            let [dx, dy] = [0, 1].map(|axis| example.tx_m[axis] - example.rx_m[axis]);
            Ok(TestLink {
                map: example.map,
                tx: example.tx,
                rx: example.rx,
                distance_m: dx.hypot(dy),
                line_of_sight: line_of_sight[i],
                dominant_peaks: peaks.dominant().len() as u32,
            })
        };
        (0..self.len()).into_par_iter().map(describe).collect()
    }
}

/// Error for maps without a link to learn from or to score; `part` names them.
pub fn no_links(part: &str, maps: &[u32]) -> Error {
    Error::Setting(format!(
        "the {part} maps {maps:?} have no link with a label; raise data.tx_per_map or data.rx_per_map, or take other maps"
    ))
}
