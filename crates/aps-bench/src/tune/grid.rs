//! The search for the settings of a model: which are tried, and which of them is best.

use crate::config::ModelConfig;
use crate::error::Result;

/// One change of a model's settings.
type Change = fn(&mut ModelConfig, usual: &ModelConfig);

/// Changes of the paper's settings, tried line by line, the same for every model. A change is made to the best settings of the lines
/// before, and is kept if it is the best of its line and better than these.
const GRID: [&[Change]; 4] = [
    &[
        |m, usual| m.learning_rate = times(usual.learning_rate, 1.0 / 3.0),
        |m, usual| m.learning_rate = times(usual.learning_rate, 3.0),
        |m, usual| m.learning_rate = times(usual.learning_rate, 10.0),
    ],
    &[
        |m, _| m.batch = Some(16),
        |m, _| m.batch = Some(32),
        |m, _| m.batch = Some(128),
    ],
    &[|m, _| m.image_size = Some(32)],
    &[|m, _| m.warmup_steps = Some(50)],
];

/// A rate times a factor, to two digits.
fn times(rate: Option<f64>, factor: f64) -> Option<f64> {
    format!("{:.1e}", rate? * factor).parse().ok()
}

/// Factors of the rate that the grid found, tried with more time: a rate may be the best for a few steps and too high for many.
const RATES_AGAIN: [f64; 3] = [1.0, 1.0 / 3.0, 0.1];

/// The second stage's share of the budget over the first one's.
const LONGER: f64 = 5.0;

/// The second stage's share of the budget, at most all of it. There is no second stage where the first has as much.
pub fn longer(share: f64) -> Option<f64> {
    let longer = (share * LONGER).min(1.0);
    (longer > share).then_some(longer)
}

/// Searches the grid at the first share, then tries rates and the usual image size again at the second, if there is one: few steps
/// favour high rates and small images. `score` gives the score of settings at a share, minus infinity where there is none.
/// Returns the best settings with their score in the last stage.
pub fn choose(
    usual: ModelConfig,
    (share, longer): (f64, Option<f64>),
    score: &mut dyn FnMut(ModelConfig, f64) -> Result<f64>,
) -> Result<(ModelConfig, f64)> {
    let mut best = (usual, score(usual, share)?);
    for line in GRID {
        let before = best.0;
        for change in line {
            let mut settings = before;
            change(&mut settings, &usual);
            if settings.image_size != before.image_size && usual.image_size.is_none() {
                continue;
            }
            best = better(best, settings, score(settings, share)?);
        }
    }
    let Some(share) = longer else {
        return Ok(best);
    };
    let found = best.0;
    best.1 = f64::NEG_INFINITY;
    for factor in RATES_AGAIN {
        let settings = ModelConfig {
            learning_rate: times(found.learning_rate, factor),
            ..found
        };
        best = better(best, settings, score(settings, share)?);
    }
    if found.image_size != usual.image_size {
        let settings = ModelConfig {
            image_size: usual.image_size,
            ..best.0
        };
        best = better(best, settings, score(settings, share)?);
    }
    Ok(best)
}

fn better(best: (ModelConfig, f64), other: ModelConfig, cosine: f64) -> (ModelConfig, f64) {
    match cosine > best.1 {
        true => (other, cosine),
        false => best,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const USUAL: ModelConfig = ModelConfig {
        image_size: Some(64),
        batch: Some(64),
        learning_rate: Some(1e-3),
        warmup_steps: Some(500),
    };

    /// The nearer a rate is to the best one of a share, the better.
    fn choice(share: f64, best_rates: [f64; 2]) -> (ModelConfig, Vec<(f64, f64)>) {
        let mut tried = Vec::new();
        let chosen = choose(USUAL, (share, longer(share)), &mut |settings, at| {
            let rate = settings.learning_rate.unwrap();
            tried.push((at, rate));
            let best = best_rates[usize::from(at > share)];
            Ok(-(rate / best).ln().abs() - f64::from(settings.batch != Some(32)))
        });
        (chosen.unwrap().0, tried)
    }

    #[test]
    fn a_rate_that_is_best_for_a_few_steps_alone_is_not_chosen() {
        let (chosen, tried) = choice(0.05, [1e-2, 1e-3]);
        assert_eq!((chosen.learning_rate, chosen.batch), (Some(1e-3), Some(32)));
        let (grid, again) = tried.split_at(tried.len() - RATES_AGAIN.len());
        assert!(grid.iter().all(|&(share, _)| share == 0.05));
        assert_eq!(again, [(0.25, 1e-2), (0.25, 3.3e-3), (0.25, 1e-3)]);
        let (chosen, _) = choice(0.05, [1e-2, 1e-2]);
        assert_eq!(chosen.learning_rate, Some(1e-2));
    }

    /// Small images are better at the first share, the usual ones at the second if `is_better_in_time`.
    fn size_chosen(is_better_in_time: bool) -> (Option<usize>, usize) {
        let mut tried = 0;
        let (chosen, _) = choose(USUAL, (0.05, longer(0.05)), &mut |settings, share| {
            let is_usual = settings.image_size == USUAL.image_size;
            let is_long = share > 0.05;
            tried += usize::from(is_long && is_usual);
            Ok(f64::from(is_usual == (is_long && is_better_in_time)))
        })
        .unwrap();
        (chosen.image_size, tried)
    }

    #[test]
    fn the_usual_image_size_is_tried_again_with_more_time() {
        assert_eq!(size_chosen(true), (USUAL.image_size, 1));
        assert_eq!(size_chosen(false), (Some(32), 1));
    }

    #[test]
    fn no_training_is_longer_than_the_budget() {
        assert_eq!(longer(0.05), Some(0.25));
        assert_eq!(longer(0.5), Some(1.0));
        assert_eq!(longer(1.0), None);
        let (chosen, tried) = choice(1.0, [1e-2, 1e-3]);
        assert_eq!(chosen.learning_rate, Some(1e-2));
        assert!(tried.iter().all(|&(share, _)| share == 1.0));
    }
}
