//! Measures the loss of the released label, which takes its maximum on a grid of delays, for a single path.
//!
//! Prints `delay_ns,loss_db` as CSV, and mean and maximum inside the grid to standard error:
//!
//!     cargo run -p aps-label --example grid_loss > grid-loss.csv
//!     python3 docs/pictures/released_grid_loss.py grid-loss.csv docs/pictures/released-grid-loss.svg

use aps_label::{LabelConfig, Labeler, PathSample, Protocol};

/// Points a grid step of 1000/127 ns.
const POINTS_A_STEP: u32 = 64;
const STEP_NS: f64 = 1000.0 / 127.0;

/// Maximum of the label of one path, relative to the path's gain \[dB\].
fn peak_db(labeler: &Labeler, delay_ns: f64) -> Result<f64, Box<dyn std::error::Error>> {
    let path = PathSample {
        delay_s: delay_ns * 1e-9,
        // From 0 deg, travelling towards 180 deg: a bin of either axis, so the array loses nothing.
        arrival_azimuth_rad: 0.0,
        gain_db: -80.0,
    };
    let label = labeler.label(&[path])?.ok_or("the path is not counted")?;
    let peak_db = label.aps_db.iter().copied().fold(f64::MIN, f64::max);
    Ok(peak_db - path.gain_db)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let released = Labeler::new(&LabelConfig::released())?;
    let paper = Labeler::new(&LabelConfig::paper())?;
    let (mut sum, mut max, mut count) = (0.0_f64, 0.0_f64, 0_u32);
    println!("delay_ns,loss_db");
    for i in 0..=POINTS_A_STEP * 140 {
        let delay_ns = f64::from(i) / f64::from(POINTS_A_STEP) * STEP_NS;
        let loss_db = Protocol::Released.sent_power_db() - peak_db(&released, delay_ns)?;
        println!("{delay_ns:.4},{loss_db:.4}");
        if i < POINTS_A_STEP * 127 {
            (sum, max, count) = (sum + loss_db, max.max(loss_db), count + 1);
            // The maximum over all delays loses nothing.
            assert!(peak_db(&paper, delay_ns)?.abs() < 1e-9);
        }
    }
    let mean = sum / f64::from(count);
    eprintln!("0 to 1000 ns: mean {mean:.2} dB, maximum {max:.2} dB");
    assert!((3.0..4.0).contains(&mean) && (11.0..13.0).contains(&max));
    Ok(())
}
