//! Distances of spectra from those of a reference.

use anyhow::Result;
use aps_label::{MeanStd, Moments, Normalization, relative_power};
use aps_metrics::{LevelDistance, Protocol, Scorer};

/// Scores of one setting over all links.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Scores {
    /// Mean over links of the mean error above the floor \[dB\].
    pub mean_db: f64,
    /// 95th percentile over links of the same \[dB\].
    pub p95_db: f64,
    /// The largest error of any link in any bin \[dB\].
    pub worst_db: f64,
    /// Mean over links of 1 - CosSim of the targets.
    pub one_minus_cosine: f64,
    /// Mean peak location error \[deg\].
    pub ple_deg: f64,
    /// Links without a spectrum where the reference has one; each counts as an empty spectrum, with CosSim 0
    /// and a PLE of 180 deg.
    pub missing: usize,
    /// Links compared.
    pub links: usize,
}

/// Scores spectra against reference ones, by the paper's definitions.
pub struct ReferenceScorer {
    target: Normalization,
    truth: Vec<Option<Vec<f64>>>,
}

impl ReferenceScorer {
    /// The reference: none for a link that is not to count.
    pub fn new(truth: Vec<Option<Vec<f64>>>) -> Result<Self> {
        let mut moments = Moments::default();
        for spectrum in truth.iter().flatten() {
            let mut values = spectrum.clone();
            relative_power(&mut values)?;
            moments.add(&values)?;
        }
        // Without a link nothing is ever normalised.
        let unit = MeanStd {
            mean: 0.0,
            std: 1.0,
        };
        Ok(Self {
            target: Normalization::Paper(
                moments.mean_std().filter(|m| m.std > 0.0).unwrap_or(unit),
            ),
            truth,
        })
    }

    /// Scores one spectrum a link.
    pub fn score(&self, found: &[Option<Vec<f64>>]) -> Result<Scores> {
        let mut scorer = Scorer::new(Protocol::Paper);
        let (mut scores, mut errors) = (Scores::default(), Vec::new());
        for (truth, found) in self.truth.iter().zip(found) {
            let Some(truth) = truth else { continue };
            scores.links += 1;
            let error = LevelDistance::of(truth, found.as_deref());
            errors.push(error.mean_db);
            scores.worst_db = scores.worst_db.max(error.worst_db);
            let Some(found) = found else {
                scores.missing += 1;
                scores.one_minus_cosine += 1.0;
                scores.ple_deg += 180.0;
                continue;
            };
            let sample = scorer.score(&self.apply(truth)?, &self.apply(found)?)?;
            scores.one_minus_cosine += 1.0 - sample.cosine;
            scores.ple_deg += sample.ple_deg;
        }
        let count = scores.links.max(1) as f64;
        scores.one_minus_cosine /= count;
        scores.ple_deg /= count;
        scores.mean_db = errors.iter().sum::<f64>() / count;
        errors.sort_by(f64::total_cmp);
        scores.p95_db = errors.get(errors.len() * 95 / 100).copied().unwrap_or(0.0);
        Ok(scores)
    }

    fn apply(&self, spectrum_db: &[f64]) -> Result<Vec<f64>> {
        let mut values = spectrum_db.to_vec();
        self.target.apply(&mut values)?;
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_itself_has_no_error_and_a_missing_link_has_all_of_it() {
        let spectrum: Vec<f64> = (0..180).map(|i| -f64::from(i % 37)).collect();
        let scorer = ReferenceScorer::new(vec![Some(spectrum.clone()), None]).unwrap();
        let same = scorer.score(&[Some(spectrum), None]).unwrap();
        assert_eq!(
            (same.links, same.missing, same.mean_db, same.ple_deg),
            (1, 0, 0.0, 0.0)
        );
        assert!(same.one_minus_cosine.abs() < 1e-12);
        let missing = scorer.score(&[None, None]).unwrap();
        assert_eq!(
            (missing.missing, missing.one_minus_cosine, missing.ple_deg),
            (1, 1.0, 180.0)
        );
    }
}
