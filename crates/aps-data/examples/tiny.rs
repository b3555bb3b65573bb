//! Writes a small data set: one map with a building, line of sight only, seen by an array of 16
//! elements.
//!
//!     cargo run -p aps-data --example tiny -- FOLDER

use std::f64::consts::PI;

use aps_data::*;

/// Power from `azimuth` at 16 elements half a wavelength apart, for a wave from `arrival` [rad].
fn array_power(azimuth: f64, arrival: f64) -> f64 {
    let psi = PI * 0.5 * (azimuth.sin() - arrival.sin());
    match psi.sin().abs() < 1e-9 {
        true => 1.0,
        false => ((16.0 * psi).sin() / (16.0 * psi.sin())).powi(2),
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let root = std::env::args().nth(1).ok_or("usage: tiny FOLDER")?;
    let mut config = DatasetConfig::default();
    config.layout.raster = RasterGrid::square(64, 64.0);
    config.configuration = serde_json::json!({ "made_by": "tiny" });
    let writer = DatasetWriter::open(&root, config)?;

    let house = vec![[20.0, 20.0], [40.0, 20.0], [40.0, 40.0], [20.0, 40.0]];
    let buildings = &Raster::of_outlines(&[house], RasterGrid::square(64, 64.0))?;
    let tx_m = &[[4.0, 4.0]];
    let rx_m = &[[10.0, 50.0], [32.0, 32.0], [50.0, 8.0]]; // the second is inside the house
    let (valid, indoors) = (LinkStatus::Valid, LinkStatus::RxInBuilding);
    let status = &[valid, indoors, valid];
    let mut aps_db = Vec::new();
    for rx in rx_m {
        let (dx, dy): (f64, f64) = (tx_m[0][0] - rx[0], tx_m[0][1] - rx[1]);
        let gain_db = -43.3 - 20.0 * dx.hypot(dy).log10(); // free space, 3.5 GHz
        aps_db.extend(Axis::ANGLE_PAPER_DEG.values().map(|azimuth_deg| {
            let power = array_power(azimuth_deg.to_radians(), dy.atan2(dx));
            gain_db + 10.0 * (power + 1e-9).log10()
        }));
    }
    let (links, argmax) = (Links::Grid, None);
    #[rustfmt::skip]
    let mut map = writer.begin_map(0, &MapInput { buildings, tx_m, rx_m, links })?;
    let aps = Some(ProfileRows {
        db: &aps_db,
        argmax,
    });
    let rows = LinkRows {
        status,
        aps,
        ..LinkRows::default()
    };
    map.push(&rows)?;
    map.finish()?;
    let totals = writer.finish(&Split::of_maps([0], 1))?.totals;
    assert!(Dataset::open(&root)?.verify().is_empty());
    println!("{} links in {root}: {:?}", totals.links, totals.status);
    Ok(())
}
