//! A small data set, written without a tracer.

use aps_data::{
    DatasetConfig, DatasetWriter, LinkRows, LinkStatus, Links, MapInput, ProfileRows, Raster,
    RasterGrid, Split,
};
use serde_json::json;
use tempfile::TempDir;

/// Angle bins of a spectrum.
pub const BINS: usize = 180;

/// Makes four maps of 2 x 8 links, one of each map's without a label; spectra are a lobe towards the transmitter.
pub fn dataset_of(protocol: &str) -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let config = DatasetConfig {
        seed: 1,
        configuration: json!({
            "label": { "protocol": protocol, "array": { "uniform_linear": {} } },
        }),
        ..DatasetConfig::default()
    };
    let writer = DatasetWriter::open(root.path(), config).unwrap();
    for id in 0..4 {
        write_map(&writer, id);
    }
    let split = Split {
        train: vec![0, 1],
        develop: vec![2],
        test: vec![3],
    };
    writer.finish(&split).unwrap();
    root
}

fn write_map(writer: &DatasetWriter, id: u32) {
    let (x, y) = (40.0 + 30.0 * f64::from(id), 90.0);
    let house = vec![[x, y], [x + 40.0, y], [x + 40.0, y + 20.0], [x, y + 20.0]];
    let buildings = Raster::of_outlines(&[house], RasterGrid::default()).unwrap();
    let tx_m = [[10.0, 20.0 + f64::from(id)], [240.0, 200.0]];
    let rx_m: Vec<[f64; 2]> = (0..8)
        .map(|i| [30.0 + 25.0 * f64::from(i), 150.0 + 7.0 * f64::from(i)])
        .collect();
    let input = MapInput {
        buildings: &buildings,
        tx_m: &tx_m,
        rx_m: &rx_m,
        links: Links::Grid,
    };
    let mut map = writer.begin_map(id, &input).unwrap();
    let mut db = Vec::new();
    for tx in tx_m {
        for rx in &rx_m {
            let angle = (tx[1] - rx[1]).atan2(tx[0] - rx[0]).to_degrees();
            let level = |bin: usize| -0.01 * (2.0 * bin as f64 - 180.0 - angle).powi(2) - 80.0;
            db.extend((0..BINS).map(level));
        }
    }
    let mut status = [LinkStatus::Valid; 16];
    status[3] = LinkStatus::NoPath;
    map.push(&LinkRows {
        status: &status,
        aps: Some(ProfileRows {
            db: &db,
            argmax: None,
        }),
        ..LinkRows::default()
    })
    .unwrap();
    map.finish().unwrap();
}
