//! Costs of the stages of data handling: one map's links, one raster, one batch of images.

use std::hint::black_box;

use aps_data::{
    ConditionConfig, ConditionImages, Dataset, DatasetConfig, DatasetWriter, LinkRows, LinkStatus,
    Links, MapInput, ProfileRows, Raster, RasterGrid, Split,
};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

const TX: usize = 20;
const RX: usize = 500;

fn city() -> Vec<Vec<[f64; 2]>> {
    let corner = |i: usize| [(i % 8 * 32) as f64, (i / 8 * 32) as f64];
    let house = |[x, y]: [f64; 2]| {
        vec![
            [x + 3.0, y],
            [x + 25.0, y + 4.0],
            [x + 21.0, y + 26.0],
            [x, y + 22.0],
        ]
    };
    (0..64).map(corner).map(house).collect()
}

fn write_map(root: &std::path::Path, aps_db: &[f64]) {
    let writer = DatasetWriter::open(root, DatasetConfig::default()).unwrap();
    let buildings = Raster::of_outlines(&city(), RasterGrid::default()).unwrap();
    let (tx_m, rx_m) = ([[1.0, 2.0]; TX], [[3.0, 4.0]; RX]);
    let mut map = writer
        .begin_map(
            0,
            &MapInput {
                buildings: &buildings,
                tx_m: &tx_m,
                rx_m: &rx_m,
                links: Links::Grid,
            },
        )
        .unwrap();
    for _ in 0..TX {
        let aps = Some(ProfileRows {
            db: aps_db,
            argmax: None,
        });
        map.push(&LinkRows {
            status: &[LinkStatus::Valid; RX],
            aps,
            ..LinkRows::default()
        })
        .unwrap();
    }
    map.finish().unwrap();
    writer.finish(&Split::of_maps([0], 0)).unwrap();
}

fn benches(c: &mut Criterion) {
    let mut group = c.benchmark_group("map of 10,000 links");
    group
        .sample_size(10)
        .throughput(Throughput::Elements((TX * RX) as u64));
    let aps_db: Vec<f64> = (0..RX * 180)
        .map(|i| -80.0 - (i % 997) as f64 / 10.0)
        .collect();
    group.bench_function("write, synced", |b| {
        b.iter_with_large_drop(|| {
            let root = tempfile::tempdir().unwrap();
            write_map(root.path(), &aps_db);
            root
        });
    });
    let root = tempfile::tempdir().unwrap();
    write_map(root.path(), &aps_db);
    let dataset = Dataset::open(root.path()).unwrap();
    group.bench_function("load and check", |b| {
        b.iter(|| dataset.map(black_box(0)).unwrap())
    });
    group.finish();

    let mut group = c.benchmark_group("images of 256 x 256");
    let polygons = city();
    group.bench_function("raster of 64 buildings", |b| {
        b.iter(|| Raster::of_outlines(black_box(&polygons), RasterGrid::default()).unwrap());
    });
    let raster = Raster::of_outlines(&polygons, RasterGrid::default()).unwrap();
    let images = ConditionImages::new(&raster, ConditionConfig::default());
    let mut image = vec![0.0; images.image_len()];
    group.bench_function("condition image", |b| {
        b.iter(|| {
            images.write(
                black_box([10.0, 20.0]),
                black_box([200.0, 100.0]),
                &mut image,
            )
        });
    });
    group.finish();
}

criterion_group!(all, benches);
criterion_main!(all);
