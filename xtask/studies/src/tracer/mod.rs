//! The tracer's limits and dynamic range: error of the label against time a link.

mod reading;
mod rows;
mod settings;

use anyhow::Result;
use aps_raytrace::TraceConfig;
use xtask::progress;

use super::errors::ReferenceScorer;
use super::links::Links;
use super::{Setup, Stopwatch, Study};
use rows::{ReferenceRow, Row};
use settings::Setting;

/// Measures.
pub fn run(setup: &Setup) -> Result<Study> {
    let scenes = setup.maps.scenes(setup.profile, setup.seed)?;
    let settings = Setting::sweep(setup.profile);
    let reference = settings::reference(setup.profile);
    let (tx, rx) = setup.profile.choose((2, 6), (4, 15));
    let bar = progress::bar((scenes.len() * (settings.len() + 1)) as u64, "settings");
    bar.set_message("tracer");
    let (mut rows, mut references) = (Vec::new(), Vec::new());
    for place in &scenes {
        let links = Links::draw(place, setup.seed, tx, rx)?;
        let began = std::time::Instant::now();
        let truth = links.reference(&reference)?;
        let compared = truth.spectra.iter().flatten().count();
        references.push(ReferenceRow {
            map: place.name.clone(),
            buildings: place.scene.building_count(),
            walls: place.scene.walls().len(),
            links: links.len(),
            compared,
            without_path: links.len() - compared,
            paths_per_link: truth.paths as f64 / links.len() as f64,
            seconds: began.elapsed().as_secs_f64(),
        });
        let scorer = ReferenceScorer::new(truth.spectra)?;
        bar.inc(1);
        // Waves of two diffractions take much memory: one setting at a time.
        for together in
            settings.chunk_by(|p, q| p.config.max_diffractions.max(q.config.max_diffractions) < 2)
        {
            let configs: Vec<&TraceConfig> = together.iter().map(|s| &s.config).collect();
            let measured = links.measure(&configs, Stopwatch::of(setup.profile))?;
            for (setting, traced) in together.iter().zip(measured) {
                let (time, scores) = (traced.time, scorer.score(&traced.spectra)?);
                rows.push(Row {
                    map: place.name.clone(),
                    walls: place.scene.walls().len(),
                    setting: setting.name.clone(),
                    group: setting.group,
                    max_reflections: setting.config.max_reflections,
                    max_diffractions: setting.config.max_diffractions,
                    dynamic_range_db: setting.config.dynamic_range_db,
                    links: scores.links,
                    missing_links: scores.missing,
                    paths_per_link: traced.paths as f64 / links.len() as f64,
                    cut_links: traced.cut_links,
                    trace_us: time.trace_us(),
                    label_us: time.label_us,
                    total_us: time.total_us(),
                    map_s: time.map_s,
                    transmitter_us: time.transmitter_us,
                    receiver_us: time.receiver_us,
                    join_us: time.join_us,
                    mean_error_db: scores.mean_db,
                    p95_error_db: scores.p95_db,
                    one_minus_cosine: scores.one_minus_cosine,
                    ple_deg: scores.ple_deg,
                });
                bar.inc(1);
            }
        }
    }
    bar.finish_and_clear();
    reading::study(setup, &references, &rows)
}
