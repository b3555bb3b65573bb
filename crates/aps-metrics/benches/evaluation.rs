//! Cost of scoring a test set, of the summary, and of finding peaks.
//!
//! The spectra look like labels: a few lobes of different heights on a low floor, in f32.

use aps_metrics::{Evaluation, PeakFinder, Protocol, Spectra, Topology};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;

const BINS: usize = 180;

/// `samples` spectra of one to twelve squared array patterns, normalised to mean 0, variance 1;
/// `jitter` \[bins\] moves the lobes.
fn spectra(samples: usize, jitter: f64) -> Vec<f32> {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut uniform = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut values = Vec::with_capacity(samples * BINS);
    for _ in 0..samples {
        let mut row = [0.0_f64; BINS];
        for _ in 0..1 + (uniform() * 12.0) as usize {
            let (centre, power) = (uniform() * 180.0 + jitter, 10_f64.powf(-3.0 * uniform()));
            for (bin, value) in row.iter_mut().enumerate() {
                let x = (bin as f64 - centre) * 0.35;
                let lobe = if x.abs() < 1e-9 {
                    1.0
                } else {
                    (x.sin() / x).powi(2)
                };
                *value = value.max(power * lobe);
            }
        }
        let mean = row.iter().sum::<f64>() / BINS as f64;
        let std = (row.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / BINS as f64).sqrt();
        values.extend(row.iter().map(|v| ((v - mean) / std) as f32));
    }
    values
}

fn evaluation(c: &mut Criterion) {
    let samples = 250_000;
    let (truth, prediction) = (spectra(samples, 0.0), spectra(samples, 0.8));
    let maps: Vec<u32> = (0..samples as u32)
        .map(|sample| 46 + sample / 50_000)
        .collect();
    let truth = Spectra::new(&truth, BINS).expect("whole rows");
    let prediction = Spectra::new(&prediction, BINS).expect("whole rows");

    let mut group = c.benchmark_group("evaluation");
    group
        .sample_size(10)
        .throughput(Throughput::Elements(samples as u64));
    let score = |protocol| {
        let mut evaluation = Evaluation::new(protocol);
        evaluation
            .push(truth, prediction, Some(&maps))
            .expect("equal shapes");
        evaluation
    };
    for protocol in Protocol::ALL {
        group.bench_function(BenchmarkId::new("score", protocol.name()), |b| {
            b.iter(|| score(black_box(protocol)));
        });
    }
    let evaluation = score(Protocol::Paper);
    let range = evaluation.truth_range().expect("finite truth");
    group.bench_function("report", |b| {
        b.iter(|| black_box(&evaluation).report(range))
    });
    group.bench_function("both protocols with reports", |b| {
        b.iter(|| Protocol::ALL.map(|p| score(p).report(range)));
    });
    group.finish();
}

fn peaks(c: &mut Criterion) {
    let values: Vec<f64> = spectra(1_000, 0.0).into_iter().map(f64::from).collect();
    let mut finder = PeakFinder::default();
    let mut group = c.benchmark_group("peaks");
    group.throughput(Throughput::Elements(1_000));
    for topology in [Topology::Line, Topology::Ring] {
        group.bench_function(format!("{topology:?}"), |b| {
            b.iter(|| {
                let found = values
                    .chunks(BINS)
                    .map(|x| finder.find(x, topology, 0.05).len());
                black_box(found.sum::<usize>())
            });
        });
    }
    group.finish();
}

criterion_group!(benches, evaluation, peaks);
criterion_main!(benches);
