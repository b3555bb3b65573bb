//! One link's label in both protocols, drawn as text: `cargo run -p aps-label --example one_label`.

use aps_label::{LabelConfig, Labeler, PathSample, Protocol};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A line of sight and two reflections; azimuths point towards where each path comes from.
    let path = |delay_ns: f64, azimuth_deg: f64, gain_db| PathSample {
        delay_s: delay_ns * 1e-9,
        arrival_azimuth_rad: azimuth_deg.to_radians(),
        gain_db,
    };
    let paths = [
        path(300.0, 20.0, -84.0),
        path(355.0, -50.0, -92.0),
        path(610.0, 66.0, -101.0),
    ];

    for protocol in Protocol::ALL {
        let labeler = Labeler::new(&LabelConfig::of(protocol))?;
        let label = labeler.label(&paths)?.ok_or("no path counts")?;
        let peak_db = label.aps_db.iter().copied().fold(f64::MIN, f64::max);
        println!("{protocol}: peak {peak_db:.2} dB");
        for ((angle, db), delay) in labeler
            .angles_deg()
            .iter()
            .zip(&label.aps_db)
            .zip(&label.aps_delay_s)
            .step_by(3)
        {
            let bar = "#".repeat((db - peak_db + 40.0).max(0.0) as usize);
            println!(
                "{angle:7.1} deg {db:8.2} dB at {:5.1} ns  {bar}",
                delay * 1e9
            );
        }
        // The continuous maximum is the strongest path's power, a little above if others add to it;
        // the released delay grid misses the path's delay and loses some.
        match protocol {
            Protocol::Paper => assert!((peak_db + 84.0).abs() < 0.1),
            _ => assert!(peak_db < -83.0),
        }
    }
    Ok(())
}
