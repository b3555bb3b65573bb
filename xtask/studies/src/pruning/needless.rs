//! A scene does not pay for what it has no geometry for.

use anyhow::Result;
use aps_raytrace::TraceConfig;
use aps_report::document::Verdict;
use aps_report::numbers::three_digits;
use indicatif::ProgressBar;
use serde::Serialize;

use crate::links::Links;
use crate::scenes::NamedScene;
use crate::{Setup, Stopwatch, Study};

/// Mechanisms that could be paid for: the line of sight alone, then more at a time.
const MECHANISMS: [&str; 4] = ["line of sight", "R2", "R2 D1", "R2 D2"];

/// Less than this, and less than a tenth, is a comparison or two and the noise of the clock [us].
const PAYING_US: f64 = 0.05;

#[derive(Debug, Clone, Serialize)]
struct Row {
    scene: String,
    walls: usize,
    convex_corners: usize,
    mechanisms: &'static str,
    paths_per_link: f64,
    /// Corners that the tracer set up.
    corners: usize,
    images_per_transmitter: f64,
    map_us: f64,
    transmitter_us: f64,
    receiver_us: f64,
    join_us: f64,
    trace_us: f64,
}

pub fn study(
    setup: &Setup,
    (tx, rx): (usize, usize),
    scenes: &[NamedScene],
    bar: &ProgressBar,
    study: &mut Study,
) -> Result<()> {
    let mut rows = Vec::new();
    for place in scenes {
        let links = Links::draw(place, setup.seed, tx, rx)?;
        let configs = MECHANISMS.map(config);
        let measured = links.measure(&configs.each_ref(), Stopwatch::of(setup.profile))?;
        for (mechanisms, traced) in MECHANISMS.into_iter().zip(measured) {
            let time = traced.time;
            rows.push(Row {
                scene: place.name.clone(),
                walls: place.scene.walls().len(),
                convex_corners: place.convex_corners(),
                mechanisms,
                paths_per_link: traced.paths as f64 / links.len() as f64,
                corners: traced.corners,
                images_per_transmitter: traced.images as f64 / tx as f64,
                map_us: 1e6 * time.map_s,
                transmitter_us: time.transmitter_us,
                receiver_us: time.receiver_us,
                join_us: time.join_us,
                trace_us: time.trace_us(),
            });
        }
        bar.inc(1);
    }
    study.section.heading("What a scene has no geometry for");
    let find = |scene: &str, mechanisms: &str| {
        rows.iter()
            .find(|r| r.scene == scene && r.mechanisms == mechanisms)
    };
    let cells = |place: &NamedScene| {
        let mut cells = vec![
            place.name.clone(),
            place.scene.walls().len().to_string(),
            place.convex_corners().to_string(),
        ];
        for mechanisms in MECHANISMS {
            let row = find(&place.name, mechanisms);
            cells.push(row.map_or(String::new(), |r| three_digits(r.trace_us)));
        }
        cells
    };
    let mut head = vec!["scene", "walls", "convex corners"];
    head.extend(MECHANISMS);
    study.table("Tracing of a link [us]", &head, scenes.iter().map(cells));
    let is_lacking = |row: &&Row| ["empty square", "courtyard"].contains(&&*row.scene);
    study.columns(
        "Its parts, in the scenes that lack something",
        rows.iter().filter(is_lacking),
        &[
            ("scene", &|row| row.scene.clone()),
            ("allowed", &|row| row.mechanisms.into()),
            ("corners set up", &|row| row.corners.to_string()),
            ("images", &|row| three_digits(row.images_per_transmitter)),
            ("map [us]", &|row| three_digits(row.map_us)),
            ("transmitter [us]", &|row| three_digits(row.transmitter_us)),
            ("receiver [us]", &|row| three_digits(row.receiver_us)),
            ("join [us]", &|row| three_digits(row.join_us)),
        ],
    );
    for verdict in verdicts(scenes, &find) {
        study.section.verdict(verdict);
    }
    study.data("needless", "Every scene by what is allowed", &rows)
}

fn config(mechanisms: &str) -> TraceConfig {
    match mechanisms {
        "line of sight" => TraceConfig::reflections_only(0),
        "R2" => TraceConfig::reflections_only(2),
        "R2 D1" => TraceConfig::within(2, 1),
        _ => TraceConfig::within(2, 2),
    }
}

/// A scene without walls must cost the same whatever is allowed, one without a corner the same with diffraction as without.
fn verdicts<'r>(
    scenes: &[NamedScene],
    find: &dyn Fn(&str, &str) -> Option<&'r Row>,
) -> Vec<Verdict> {
    let compare = |place: &NamedScene, base: &str, needless: &str| {
        let least = find(&place.name, base)?.trace_us;
        let more = MECHANISMS.iter().skip_while(|m| **m != base).skip(1);
        let times = more.filter_map(|m| Some(find(&place.name, m)?.trace_us));
        let most = times.fold(least, f64::max);
        let most_allowed = (1.1 * least).max(least + PAYING_US);
        let claim = format!("{}, paying for {needless}", place.name);
        Some(Verdict::bound(claim, most, most_allowed, "us"))
    };
    let verdict = |place: &NamedScene| match (place.scene.walls().len(), place.name.as_str()) {
        (0, _) => compare(place, MECHANISMS[0], "reflection or diffraction"),
        (_, "courtyard") => compare(place, MECHANISMS[1], "diffraction"),
        _ => None,
    };
    scenes.iter().filter_map(verdict).collect()
}
