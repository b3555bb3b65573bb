//! Links to look at: one that is easy, one in the middle, and the worst.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result};
use aps_metrics::Metric;
use aps_model::ANGLE_BINS;
use aps_report::benchmark::{Entry, EntryKind, Example, Prediction, ScoreTable};
use map2aps::DatasetPlan;

use super::answer;
use super::test_set::TestSet;

/// Share of the links that are predicted worse than the example.
const DIFFICULTIES: [(&str, f64); 3] = [("easy", 0.9), ("median", 0.5), ("worst", 0.0)];

/// Examples by the mean cosine similarity of the models, or of everything if there is no model. `folder_of` says where
/// an entry's predictions lie.
pub fn choose(
    entries: &[Entry],
    test: &TestSet,
    plan: &DatasetPlan,
    root: &Path,
    folder_of: impl Fn(&str) -> std::path::PathBuf,
) -> Result<Vec<Example>> {
    let is_model = |e: &&Entry| matches!(e.kind, EntryKind::Model | EntryKind::Ablation);
    let has_models = entries.iter().any(|e| is_model(&e));
    let mut sum = vec![0.0; test.len()];
    for entry in entries.iter().filter(|e| !has_models || is_model(e)) {
        let scores = entry.scores.first().context("an entry has no scores")?;
        let table = ScoreTable::read(root, scores, test.len())?;
        let cosine = table.column(Metric::Cosine).context("cosine is scored")?;
        sum.iter_mut().zip(cosine).for_each(|(s, c)| *s += c);
    }
    let mut order: Vec<usize> = (0..test.len()).collect();
    order.sort_by(|&a, &b| sum[a].total_cmp(&sum[b]));
    let chosen = DIFFICULTIES.map(|(name, share)| {
        let rank = (share * (order.len() - 1) as f64).round() as usize;
        (name, order[rank])
    });
    let mut predictions: BTreeMap<usize, Vec<Prediction>> = BTreeMap::new();
    for entry in entries {
        let all = answer::predictions(&folder_of(&entry.name))?;
        for (_, link) in chosen {
            let spectrum = &all[link * ANGLE_BINS..][..ANGLE_BINS];
            let prediction = Prediction {
                entry: entry.name.clone(),
                spectrum: spectrum.iter().copied().map(f64::from).collect(),
            };
            let of_link = predictions.entry(link).or_default();
            if of_link.iter().all(|p| p.entry != entry.name) {
                of_link.push(prediction);
            }
        }
    }
    let example = |(name, link): (&str, usize)| {
        let ends = test.labels().links()[link];
        Ok(Example {
            difficulty: name.into(),
            link,
            truth: test.labels().target(link).to_vec(),
            predictions: predictions.get(&link).cloned().unwrap_or_default(),
            buildings: plan.outlines(test.labels().rows()[link].map)?,
            tx_m: ends.tx_m,
            rx_m: ends.rx_m,
        })
    };
    chosen.into_iter().map(example).collect()
}
