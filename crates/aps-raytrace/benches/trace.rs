//! Benchmarks of each stage: `cargo bench -p aps-raytrace`.
//!
//! The default synthetic city, 256 m x 256 m; one scene, 8 transmitters, 64 receivers.

mod common;

use std::hint::black_box;

use aps_raytrace::scene::CityConfig;
use aps_raytrace::{Link, Receiver, Scene, TraceConfig, Tracer, Transmitter};
use common::outdoor;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn stages(c: &mut Criterion) {
    let city = CityConfig::default();
    let footprints = city.footprints().unwrap();
    let scene = Scene::synthetic(&city).unwrap();
    let points = outdoor(&scene, 72);
    c.bench_function("scene", |b| {
        b.iter(|| Scene::new(black_box(&footprints), scene.area()).unwrap());
    });
    let with_fallback = TraceConfig {
        max_fallback_diffractions: 4,
        ..TraceConfig::default()
    };
    let limits = [
        ("R2", TraceConfig::reflections_only(2)),
        ("R2 D1", TraceConfig::default()),
        ("R2 D1 fallback", with_fallback),
        ("R5 D2, 20 dB", TraceConfig::converged()),
    ];
    for (name, config) in limits {
        let mut group = c.benchmark_group(name);
        group.bench_function("map", |b| {
            b.iter(|| Tracer::new(black_box(&scene), config.clone()).unwrap());
        });
        let tracer = Tracer::new(&scene, config.clone()).unwrap();
        group.bench_function("transmitter", |b| {
            b.iter(|| tracer.transmitter(black_box(points[0])).unwrap());
        });
        group.bench_function("receiver", |b| {
            b.iter(|| tracer.receiver(black_box(points[8])).unwrap());
        });
        let tx: Vec<Transmitter> = points[..8]
            .iter()
            .map(|&p| tracer.transmitter(p).unwrap())
            .collect();
        let rx: Vec<Receiver> = points[8..]
            .iter()
            .map(|&p| tracer.receiver(p).unwrap())
            .collect();
        let mut link = Link::default();
        group.throughput(Throughput::Elements((tx.len() * rx.len()) as u64));
        group.bench_function("512 links", |b| {
            b.iter(|| {
                for tx in &tx {
                    for rx in &rx {
                        tracer.link(tx, rx, &mut link).unwrap();
                        black_box(&link);
                    }
                }
            });
        });
        group.finish();
    }
}

criterion_group!(benches, stages);
criterion_main!(benches);
