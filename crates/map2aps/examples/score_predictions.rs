//! Scores a prediction for the test maps of the data set in `data/example`: the mean spectrum of the training maps.

use std::path::Path;

use map2aps::{Dataset, Domain, Examples, Metric, Part, Prediction, Scoring, Truth};

/// Runs the example.
pub fn main() -> map2aps::Result<()> {
    let folder = Path::new("data/example");
    let train = Examples::load(&Dataset::open(folder)?, Part::Train, Domain::Normalised)?;
    let (bins, links) = (train.bins(), train.list().len());
    let mut mean = vec![0.0; bins];
    for (i, value) in train.targets()?.iter().enumerate() {
        mean[i % bins] += value / links as f32;
    }
    let mut truth = Truth::dataset(folder, Part::Test, Domain::Normalised)?;
    let values = &mean.repeat(truth.shape().samples);
    let scores = Scoring::default().score(&mut truth, Prediction::Values { values, bins })?;
    let all = &scores.report.overall;
    for metric in Metric::PAPER_COLUMNS {
        println!("{} {:?}", metric.label(), all.get(metric).map(|d| d.mean));
    }
    Ok(())
}
