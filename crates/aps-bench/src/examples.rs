//! Links to look at: those that the best model predicts best, as the median, and worst.

use std::path::{Path, PathBuf};

use aps_metrics::Metric;
use aps_model::ANGLE_BINS;
use aps_report::benchmark::{Entry, Example, Prediction, ScoreTable};
use map2aps::DatasetPlan;

use crate::answer;
use crate::error::{Error, Result};
use crate::test_set::TestSet;

/// Name of each link to look at, and the share of all links that are predicted worse.
const RANKS: [(&str, f64); 3] = [("best", 1.0), ("median", 0.5), ("worst", 0.0)];

/// Chooses links by the cosine similarity of one entry: the model with the best mean, or the best entry if there is no model.
/// `folder_of` says where an entry's predictions lie.
pub fn choose(
    entries: &[Entry],
    test: &TestSet,
    plan: &DatasetPlan,
    root: &Path,
    folder_of: impl Fn(&str) -> PathBuf,
) -> Result<Vec<Example>> {
    let mut best: Option<(&Entry, Vec<f64>)> = None;
    let value = |of: &Option<(&Entry, Vec<f64>)>| {
        let of = of.as_ref();
        of.map(|(entry, cosine)| (entry.kind.is_learned(), cosine.iter().sum::<f64>()))
    };
    for entry in entries {
        let scores = entry.scores.first().ok_or(Error::NothingScored)?;
        let table = ScoreTable::read(root, scores, test.len())?;
        let cosine = table.column(Metric::Cosine).ok_or(Error::NothingScored)?;
        let this = Some((entry, cosine.to_vec()));
        if value(&this) > value(&best) {
            best = this;
        }
    }
    let (entry, cosine) = best.ok_or(Error::NothingScored)?;
    let mut order: Vec<usize> = (0..test.len()).collect();
    order.sort_by(|&a, &b| cosine[a].total_cmp(&cosine[b]));
    let predictions = answer::predictions(&folder_of(&entry.name), test.len())?;
    let example = |(rank, share): (&str, f64)| {
        let link = order[(share * (order.len() - 1) as f64).round() as usize];
        let example = test.examples.list()[link];
        let spectrum = &predictions[link * ANGLE_BINS..][..ANGLE_BINS];
        Ok(Example {
            rank: rank.into(),
            link,
            truth: test.examples.target(link).to_vec(),
            predictions: vec![Prediction {
                entry: entry.name.clone(),
                spectrum: spectrum.iter().copied().map(f64::from).collect(),
            }],
            buildings: plan.outlines(example.map)?,
            tx_m: example.tx_m,
            rx_m: example.rx_m,
        })
    };
    RANKS.into_iter().map(example).collect()
}
