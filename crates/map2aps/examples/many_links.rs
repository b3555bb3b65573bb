//! Traces and labels 50,000 links of a map in memory: those of 100 transmitters, the first rows of an array of shape (600, 2),
//! to 500 receivers, the others.
//!
//!     cargo run --release -p map2aps --example many_links -- path/to/maps/0.json terminals.npy

use std::path::Path;
use std::time::Instant;

use map2aps::aps_data::npy;
use map2aps::aps_label::Labeler;
use map2aps::aps_raytrace::Tracer;
use map2aps::aps_raytrace::glam::DVec2;
use map2aps::maps::{SceneSettings, TileSettings, load_file};
use map2aps::{Control, LabelConfig, Limits, label_links, trace_links};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let [map, terminals] = &files[..] else {
        return Err("name a map and an array of terminals".into());
    };
    let tiles = TileSettings::default();
    let (scene, _) = load_file(Path::new(map), None, tiles, SceneSettings::default())?;
    let terminals = npy::read::<f64>(Path::new(terminals))?;
    let (points, _) = terminals.data.as_chunks();
    let points: Vec<DVec2> = points.iter().copied().map(DVec2::from).collect();
    let (tx, rx) = points.split_at_checked(100).ok_or("fewer than 100 rows")?;

    let (control, started) = (Control::default(), Instant::now());
    let tracer = Tracer::new(&scene, Limits::default().config())?;
    let paths = trace_links(&tracer, tx, rx, &control)?;
    let labels = label_links(&Labeler::new(&LabelConfig::released())?, &paths, &control)?;
    let labelled = labels.is_labelled.iter().filter(|is| **is).count();
    let (links, took) = (paths.links(), started.elapsed());
    println!("{links} links, {labelled} of them labelled, in {took:.2?}");
    Ok(())
}
