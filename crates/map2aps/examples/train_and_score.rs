//! Trains a model on the data set in `data/example`, and scores its predictions for the test maps.

use std::path::Path;

use map2aps::aps_model::{ANGLE_BINS, ModelKind, Preset};
use map2aps::training::Training;
use map2aps::{
    Control, Dataset, Domain, Examples, Metric, Part, Prediction, Result, Scoring, Truth,
};

/// Runs the example.
pub fn main() -> Result<()> {
    let (folder, run) = (Path::new("data/example"), Path::new("data/run"));
    let dataset = Dataset::open(folder)?;
    let mut training = Training::new(ModelKind::MsMlp, Preset::Small);
    training.config.epochs = 1;
    let trained = training.run(&dataset, run, &Control::default())?;
    let test = Examples::load(&dataset, Part::Test, Domain::Normalised)?;
    let (values, bins) = (&trained.predict(&test)?, ANGLE_BINS);
    let mut truth = Truth::dataset(folder, Part::Test, Domain::Normalised)?;
    let scores = Scoring::default().score(&mut truth, Prediction::Values { values, bins })?;
    for metric in Metric::PAPER_COLUMNS {
        let mean = scores.report.overall.get(metric).map(|d| d.mean);
        println!("{} {mean:?}", metric.label());
    }
    Ok(())
}
