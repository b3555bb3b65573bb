//! Confidence intervals of means over links that come in clusters (cluster bootstrap).
//!
//! Links of one transmitter share most of their surroundings, and transmitters of one map share its
//! buildings. An interval that takes links for independent draws is therefore far too narrow. The
//! bootstrap here draws what was drawn when the data were made, in the same order: maps with
//! replacement, then, in each map drawn, as many of its transmitters with replacement, each with all
//! of its links. The mean over the links so drawn is one replicate; its percentiles over many
//! replicates are the interval (Davison and Hinkley, "Bootstrap Methods and their Application",
//! 1997, section 3.8 for data in hierarchies, section 5.3 for percentiles).
//!
//! ```
//! use aps_metrics::Bootstrap;
//!
//! // Map and transmitter of six links, and what a metric says of each.
//! let clusters = [(46, 0), (46, 0), (46, 1), (47, 0), (47, 1), (47, 1)];
//! let cosine = [0.9, 0.8, 0.7, 0.95, 0.85, 0.9];
//! let resamples = Bootstrap::default().draw(&clusters)?;
//! let estimate = resamples.mean(&cosine)?.ok_or("no links")?;
//! assert!((estimate.mean - 0.85).abs() < 1e-12);
//! assert!(estimate.low < estimate.mean && estimate.mean < estimate.high);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Limits
//!
//! A single map does not show how much maps differ: the interval then covers the choice of
//! transmitters only. With a handful of maps, as the benchmark's five, percentile
//! intervals come out too narrow: where maps differ more than transmitters, the variance of the mean
//! is estimated too small by the factor 1 - 1/maps, which is 11 % of the width for five maps.

use std::ops::Range;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use crate::distribution::{compensated_sum, quantiles};
use crate::error::Error;

/// Settings of the bootstrap. The default is 2000 replicates, 95 %, seed 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bootstrap {
    /// Number of replicates; 2000 give the ends of a 95 % interval to about 3 % of its width. With
    /// 0 the interval is the mean itself.
    pub replicates: usize,
    /// Share of the replicates inside the interval, in \[0, 1\].
    pub level: f64,
    /// Seed of all draws: equal seeds and clusters make equal intervals, on any number of threads.
    pub seed: u64,
}

impl Default for Bootstrap {
    fn default() -> Self {
        Self {
            replicates: 2000,
            level: 0.95,
            seed: 0,
        }
    }
}

/// A mean and its confidence interval. Every number is finite.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Estimate {
    /// Arithmetic mean over all samples.
    pub mean: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
    /// Number of samples, at least 1.
    pub samples: usize,
}

/// Replicates drawn once for any number of metrics. Two models are compared on the same replicates,
/// so that the mean of their differences, link by link, is a paired comparison.
#[derive(Debug, Clone)]
pub struct Resamples {
    /// Number of each sample's cluster.
    cluster_of: Vec<u32>,
    /// Number of samples of each cluster.
    sizes: Vec<f64>,
    /// Number of times each cluster was drawn, shape (replicates, clusters).
    drawn: Vec<u32>,
    level: f64,
}

impl Bootstrap {
    /// Draws replicates for samples in any order; `clusters` gives map and transmitter of each.
    ///
    /// O(replicates * transmitters) time and memory, 4 bytes each.
    ///
    /// # Errors
    /// [`Error::Level`] for a level that is no share, [`Error::Replicates`] for more than memory can be taken for.
    pub fn draw(&self, clusters: &[(u32, u32)]) -> Result<Resamples, Error> {
        if !(0.0..=1.0).contains(&self.level) {
            return Err(Error::Level(self.level));
        }
        let mut keys = clusters.to_vec();
        keys.sort_unstable();
        keys.dedup();
        let number = |key| keys.binary_search(key).expect("every key is in the list") as u32;
        let cluster_of: Vec<u32> = clusters.iter().map(number).collect();
        let mut sizes = vec![0.0; keys.len()];
        for &cluster in &cluster_of {
            sizes[cluster as usize] += 1.0;
        }
        let too_many = Error::Replicates {
            replicates: self.replicates,
            clusters: keys.len(),
        };
        let counts = self.replicates.checked_mul(keys.len());
        let counts = counts.ok_or(too_many)?;
        let mut drawn = Vec::new();
        drawn.try_reserve_exact(counts).map_err(|_| too_many)?;
        drawn.resize(counts, 0);
        if !keys.is_empty() {
            // The clusters of each map.
            let mut maps: Vec<Range<usize>> = Vec::new();
            for map in keys.chunk_by(|a, b| a.0 == b.0) {
                let start = maps.last().map_or(0, |before| before.end);
                maps.push(start..start + map.len());
            }
            let replicates = drawn.par_chunks_mut(keys.len()).enumerate();
            replicates.for_each(|(replicate, counts)| {
                let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
                rng.set_stream(replicate as u64);
                for _ in 0..maps.len() {
                    let map = &maps[below(&mut rng, maps.len())];
                    for _ in 0..map.len() {
                        counts[map.start + below(&mut rng, map.len())] += 1;
                    }
                }
            });
        }
        Ok(Resamples {
            cluster_of,
            sizes,
            drawn,
            level: self.level,
        })
    }
}

/// Largest magnitude of a value: beyond any metric's, and no sum of such overflows.
const MAX_VALUE: f64 = 1e160;

impl Resamples {
    /// Returns the mean of one value a sample, in the order of [`Bootstrap::draw`]'s clusters, with
    /// its percentile interval; `None` if there are no samples. A replicate with more links in it
    /// weighs none of them less: it is the mean over its links. O(samples + replicates *
    /// transmitters).
    ///
    /// # Errors
    /// [`Error::ValuesOfSamples`] unless there is one value a sample; [`Error::NotFinite`] for one
    /// that is NaN, infinite or beyond 1e160, which no metric is.
    pub fn mean(&self, values: &[f64]) -> Result<Option<Estimate>, Error> {
        let samples = self.cluster_of.len();
        if values.len() != samples {
            return Err(Error::ValuesOfSamples {
                values: values.len(),
                samples,
            });
        }
        let is_bad = |v: &f64| !v.is_finite() || v.abs() > MAX_VALUE;
        if let Some(index) = values.iter().position(is_bad) {
            let limit = MAX_VALUE;
            return Err(Error::NotFinite { index, limit });
        }
        if samples == 0 {
            return Ok(None);
        }
        let mean = compensated_sum(values.iter().copied()) / samples as f64;
        // Sums of what is above the mean: a replicate then loses nothing to a large common part.
        let mut sums = vec![0.0; self.sizes.len()];
        for (&cluster, value) in self.cluster_of.iter().zip(values) {
            sums[cluster as usize] += value - mean;
        }
        let replicate = |counts: &[u32]| {
            let (mut sum, mut size) = (0.0, 0.0);
            for ((&count, s), n) in counts.iter().zip(&sums).zip(&self.sizes) {
                sum += f64::from(count) * s;
                size += f64::from(count) * n;
            }
            mean + sum / size
        };
        let mut means: Vec<f64> = self
            .drawn
            .par_chunks(self.sizes.len())
            .map(replicate)
            .collect();
        let tail = (1.0 - self.level) / 2.0;
        let [low, high] = match means.is_empty() {
            true => [mean; 2],
            false => quantiles(&mut means, [tail, 1.0 - tail]),
        };
        Ok(Some(Estimate {
            mean,
            low,
            high,
            samples,
        }))
    }
}

/// A whole number below `n`, all equally likely to one part in 2^64 / n: the high word of 64 random bits times `n`.
fn below(rng: &mut ChaCha8Rng, n: usize) -> usize {
    ((u128::from(rng.next_u64()) * n as u128) >> 64) as usize
}
