//! Benchmarks of the polar view: `cargo bench -p aps-raytrace --bench polar`.
//!
//! The default synthetic city, or the RadioMapSeer map that `POLAR_MAP` names; 720 directions, two bounces; one thread with
//! `RAYON_NUM_THREADS=1`.

mod common;

use std::hint::black_box;

use aps_raytrace::Scene;
use aps_raytrace::polar::{Fan, PolarLink, PolarMap};
use aps_raytrace::scene::CityConfig;
use common::outdoor;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn polar(c: &mut Criterion) {
    let scene = match std::env::var("POLAR_MAP") {
        Ok(path) => Scene::from_radiomapseer(&std::fs::read_to_string(path).unwrap()).unwrap(),
        Err(_) => Scene::synthetic(&CityConfig::default()).unwrap(),
    };
    let points = outdoor(&scene, 48);
    let mut group = c.benchmark_group("polar");
    group.bench_function("map", |b| {
        b.iter(|| PolarMap::new(black_box(&scene), Fan::default()).unwrap());
    });
    let map = PolarMap::new(&scene, Fan::default()).unwrap();
    let (tx, rx) = points.split_at(16);
    group.throughput(Throughput::Elements(tx.len() as u64));
    group.bench_function("16 transmitters", |b| {
        b.iter(|| {
            tx.iter()
                .map(|&p| map.transmitter(p).unwrap())
                .collect::<Vec<_>>()
        });
    });
    group.throughput(Throughput::Elements(rx.len() as u64));
    group.bench_function("32 receivers", |b| {
        b.iter(|| {
            rx.iter()
                .map(|&p| map.receiver(p).unwrap())
                .collect::<Vec<_>>()
        });
    });
    let tx: Vec<_> = tx.iter().map(|&p| map.transmitter(p).unwrap()).collect();
    let rx: Vec<_> = rx.iter().map(|&p| map.receiver(p).unwrap()).collect();
    let links: Vec<PolarLink<'_>> = tx[..8]
        .iter()
        .flat_map(|transmitter| rx.iter().map(move |receiver| (transmitter, receiver)))
        .map(|(transmitter, receiver)| PolarLink {
            map: &map,
            transmitter,
            receiver,
        })
        .collect();
    let mut ways = Vec::new();
    group.throughput(Throughput::Elements(links.len() as u64));
    group.bench_function("256 links", |b| {
        b.iter(|| {
            for link in black_box(&links) {
                ways.clear();
                link.ways(&mut ways).unwrap();
            }
        });
    });
    group.finish();
}

criterion_group!(benches, polar);
criterion_main!(benches);
