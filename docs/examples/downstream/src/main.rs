//! From footprints to an angle power spectrum with two of the crates: is the direct way free, and where does power come from?

use aps_label::{LabelConfig, Labeler, PathSample};
use aps_raytrace::{Scene, TraceConfig, Tracer, glam::DVec2};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Two houses, a street between them; metres.
    let scene = Scene::from_radiomapseer(
        "[[[20, 20], [60, 20], [60, 50], [20, 50]], [[20, 65], [60, 65], [60, 90], [20, 90]]]",
    )?;
    let tracer = Tracer::new(&scene, TraceConfig::default())?;
    let link = tracer.trace(DVec2::new(10.0, 30.0), DVec2::new(80.0, 58.0))?;
    let is_free = link.paths.iter().any(|path| path.is_line_of_sight());
    println!(
        "{} paths, the direct one {}among them",
        link.paths.len(),
        if is_free { "" } else { "not " }
    );

    // The crates do not know each other: this is all that joins them.
    let sample = |path: &aps_raytrace::PathRecord| PathSample {
        delay_s: path.delay_s,
        arrival_azimuth_rad: path.arrival_azimuth_rad,
        gain_db: path.gain_db(),
    };
    let samples: Vec<PathSample> = link.paths.iter().map(sample).collect();
    let labeler = Labeler::new(&LabelConfig::paper())?;
    let label = labeler.label(&samples)?.ok_or("no path, no label")?;

    let bins = labeler.angles_deg().iter().zip(&label.aps_db);
    let strongest = bins.max_by(|a, b| a.1.total_cmp(b.1)).ok_or("no bins")?;
    println!("most power from {} deg: {:.1} dB", strongest.0, strongest.1);
    assert!(!is_free && label.aps_db.len() == 180);
    Ok(())
}
