//! Trains two models once on a few synthetic links, and tells how they do beside the baselines.

use aps_bench::{Benchmark, Profile, Watch};
use aps_metrics::Metric;
use aps_model::ModelKind;
use aps_report::benchmark::ScoreTable;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::path::Path::new("data/tiny-benchmark");
    let mut config = Profile::Smoke.config();
    config.models = vec![ModelKind::MsMlp, ModelKind::PolarReg];
    config.training.epochs = Some(1);
    let results = Benchmark::new(config, folder)?.run(Watch::default())?;
    for entry in &results.entries {
        let scores = ScoreTable::read(folder, &entry.scores[0], results.links.len())?;
        println!("{}: CosSim {:?}", entry.name, scores.mean(Metric::Cosine));
    }
    Ok(())
}
