//! Benchmarks of the fields: `cargo bench -p aps-raytrace --bench fields`.
//!
//! The default synthetic city, or the RadioMapSeer map that `FIELDS_MAP` names; 256 x 256 pixels, 180 x 40 positions; one thread
//! with `RAYON_NUM_THREADS=1`.

use std::hint::black_box;

use aps_raytrace::Scene;
use aps_raytrace::fields::{FieldConfig, FieldLink, FieldMap, Mirror, NUMBERS, PLANES, gather};
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{CityConfig, Location};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn outdoor(scene: &Scene, count: usize) -> Vec<DVec2> {
    (0..)
        .map(|i: u32| {
            let j = i.wrapping_mul(2_654_435_761) >> 9;
            DVec2::new(f64::from(j % 257), f64::from(j / 257 % 257))
        })
        .filter(|&p| scene.locate(p) == Location::Outdoor)
        .take(count)
        .collect()
}

fn fields(c: &mut Criterion) {
    let scene = match std::env::var("FIELDS_MAP") {
        Ok(path) => Scene::from_radiomapseer(&std::fs::read_to_string(path).unwrap()).unwrap(),
        Err(_) => Scene::synthetic(&CityConfig::default()).unwrap(),
    };
    let points = outdoor(&scene, 48);
    let mut group = c.benchmark_group("fields");
    group.bench_function("map", |b| {
        b.iter(|| FieldMap::new(black_box(&scene), FieldConfig::default()).unwrap());
    });
    let map = FieldMap::new(&scene, FieldConfig::default()).unwrap();
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
    let links: Vec<FieldLink<'_>> = tx[..8]
        .iter()
        .flat_map(|transmitter| rx.iter().map(move |receiver| (transmitter, receiver)))
        .zip((0..4).cycle())
        .map(|((transmitter, receiver), image)| FieldLink {
            map: &map,
            transmitter,
            receiver,
            mirror: Mirror::ALL[image],
        })
        .collect();
    let mut planes = vec![0.0; links.len() * PLANES * map.fan().positions()];
    let mut numbers = vec![0.0; links.len() * NUMBERS * map.fan().directions];
    group.throughput(Throughput::Elements(links.len() as u64));
    group.bench_function("256 links", |b| {
        b.iter(|| gather(black_box(&links), &mut planes, &mut numbers).unwrap());
    });
    group.finish();
}

criterion_group!(benches, fields);
criterion_main!(benches);
