//! The tracer's limits and dynamic range: error of the label against time a link.

mod reading;
mod settings;

use anyhow::Result;
use aps_raytrace::TraceConfig;
use serde::Serialize;
use xtask::progress;

use super::errors::{Judge, Scores};
use super::links::{LinkTime, Links};
use super::{Setup, Stopwatch, Study};
use settings::Setting;

/// Cost and errors of a setting on one map.
#[derive(Debug, Clone, Serialize)]
struct Row {
    map: String,
    walls: usize,
    setting: String,
    group: &'static str,
    max_reflections: usize,
    max_diffractions: usize,
    dynamic_range_db: Option<f64>,
    links: usize,
    missing_links: usize,
    paths_per_link: f64,
    /// Links with more paths than a label takes: the strongest are labelled.
    cut_links: usize,
    trace_us: f64,
    label_us: f64,
    total_us: f64,
    map_s: f64,
    transmitter_us: f64,
    receiver_us: f64,
    join_us: f64,
    mean_error_db: f64,
    p95_error_db: f64,
    one_minus_cosine: f64,
    ple_deg: f64,
}

/// Costs of the reference on one map.
#[derive(Debug, Clone, Serialize)]
struct ReferenceRow {
    map: String,
    buildings: usize,
    walls: usize,
    /// Links drawn.
    links: usize,
    /// Links that are compared.
    compared: usize,
    /// Links without a path.
    without_path: usize,
    paths_per_link: f64,
    seconds: f64,
}

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
        let judge = Judge::new(truth.spectra)?;
        bar.inc(1);
        // Waves of two diffractions take much memory: one setting at a time.
        for together in
            settings.chunk_by(|p, q| p.config.max_diffractions.max(q.config.max_diffractions) < 2)
        {
            let configs: Vec<&TraceConfig> = together.iter().map(|s| &s.config).collect();
            let measured = links.measure(&configs, Stopwatch::of(setup.profile))?;
            for (setting, traced) in together.iter().zip(measured) {
                let scores = judge.score(&traced.spectra)?;
                let last = references.last().expect("one was pushed");
                rows.push(Row {
                    paths_per_link: traced.paths as f64 / links.len() as f64,
                    cut_links: traced.cut_links,
                    ..Row::new(last, setting, &traced.time, &scores)
                });
                bar.inc(1);
            }
        }
    }
    bar.finish_and_clear();
    reading::study(setup, &references, &rows)
}

impl Row {
    fn new(map: &ReferenceRow, setting: &Setting, t: &LinkTime, s: &Scores) -> Self {
        Self {
            map: map.map.clone(),
            walls: map.walls,
            setting: setting.name.clone(),
            group: setting.group,
            max_reflections: setting.config.max_reflections,
            max_diffractions: setting.config.max_diffractions,
            dynamic_range_db: setting.config.dynamic_range_db,
            links: s.links,
            missing_links: s.missing,
            paths_per_link: 0.0,
            cut_links: 0,
            trace_us: t.trace_us(),
            label_us: t.label_us,
            total_us: t.total_us(),
            map_s: t.map_s,
            transmitter_us: t.transmitter_us,
            receiver_us: t.receiver_us,
            join_us: t.join_us,
            mean_error_db: s.mean_db,
            p95_error_db: s.p95_db,
            one_minus_cosine: s.one_minus_cosine,
            ple_deg: s.ple_deg,
        }
    }
}
