//! Scores a prediction against the truth, both `.npy` files of shape (samples, bins) in float32:
//!
//! `cargo run --release -p aps-metrics --example score -- truth.npy prediction.npy`
//!
//! Without files it scores 1,000 sums of waves against noisy copies of themselves.

use std::{env, error::Error, fs, time::Instant};

use aps_metrics::{Evaluation, Metric, Protocol, Spectra};

/// Reads the values of a `.npy` file and the length of its rows.
fn read(path: &str) -> Result<(Vec<f32>, usize), Box<dyn Error>> {
    let bytes = fs::read(path)?;
    let file = npyz::NpyFile::new(&bytes[..])?;
    let bins = *file.shape().last().ok_or("not an array of spectra")?;
    Ok((file.into_vec()?, bins as usize))
}

fn waves(noise: f32) -> (Vec<f32>, usize) {
    let value = |i: usize| {
        let (sample, bin) = ((i / 180) as f32, (i % 180) as f32);
        (bin * 0.1 + sample).sin() + (bin * 0.3).cos() + noise * (i as f32 * 13.0).sin()
    };
    ((0..180_000).map(value).collect(), 180)
}

fn main() -> Result<(), Box<dyn Error>> {
    let files: Vec<String> = env::args().skip(1).collect();
    let (truth, prediction) = match &files[..] {
        [truth, prediction] => (read(truth)?, read(prediction)?),
        _ => (waves(0.0), waves(0.1)),
    };
    let truth = Spectra::new(&truth.0, truth.1)?;
    let prediction = Spectra::new(&prediction.0, prediction.1)?;

    for protocol in Protocol::ALL {
        let start = Instant::now();
        let mut evaluation = Evaluation::new(protocol);
        evaluation.push(truth, prediction, None)?;
        let range = evaluation.truth_range().ok_or("no truth is finite")?;
        let report = evaluation.report(range);
        let seconds = start.elapsed().as_secs_f64();

        let (name, samples) = (protocol.name(), evaluation.samples());
        println!("{name} protocol: {samples} samples in {seconds:.4} s");
        println!("{} rejected", evaluation.rejected().len());
        for metric in Metric::ALL {
            let d = report.overall.get(metric).ok_or("nothing was scored")?;
            let (label, mean, std, median) = (metric.label(), d.mean, d.std, d.median);
            println!("{label:>13} {mean:9.4} +- {std:8.4}, median {median:9.4}");
        }
    }
    Ok(())
}
