//! Scenes with and without each omission that can be turned off.

use std::iter;

use anyhow::{Context, Result};
use aps_raytrace::TraceConfig;
use aps_report::chart::{Axis, Chart, Spot};
use aps_report::numbers::{fixed, small, three_digits};
use indicatif::ProgressBar;
use serde::Serialize;

use crate::errors::ReferenceScorer;
use crate::links::Links;
use crate::scenes::NamedScene;
use crate::{Setup, Stopwatch, Study};

#[derive(Debug, Clone, Serialize)]
struct Row {
    scene: String,
    walls: usize,
    convex_corners: usize,
    omission: &'static str,
    links: usize,
    /// Links with a path in either case.
    compared: usize,
    paths_per_link: f64,
    left_out_per_link: f64,
    total_us: f64,
    trace_us: f64,
    label_us: f64,
    /// Time with the omission over time without it.
    time_ratio: f64,
    /// Links that have a spectrum only without the omission.
    lost_links: usize,
    mean_error_db: f64,
    p95_error_db: f64,
    worst_error_db: f64,
}

/// Limits, without an omission, and with each that is measured: its name and range \[dB\].
type Omissions = (TraceConfig, [(&'static str, f64); 2]);

/// Ranges to be measured: two of R2 D1, and two of the converged limits.
fn omissions() -> [Omissions; 2] {
    let all = |limits: TraceConfig| TraceConfig {
        dynamic_range_db: None,
        ..limits
    };
    [
        (
            all(TraceConfig::within(2, 1)),
            [("R2 D1, beyond 60 dB", 60.0), ("R2 D1, beyond 30 dB", 30.0)],
        ),
        (
            all(TraceConfig::converged()),
            [("R5 D2, beyond 30 dB", 30.0), ("R5 D2, beyond 20 dB", 20.0)],
        ),
    ]
}

pub fn study(
    setup: &Setup,
    ends: (usize, usize),
    scenes: &[NamedScene],
    bar: &ProgressBar,
    study: &mut Study,
) -> Result<()> {
    let mut rows = Vec::new();
    for place in scenes {
        rows.extend(of_scene(setup, ends, place)?);
        bar.inc(1);
    }
    study.section.heading("Omissions that can be turned off");
    let change = |r: &Row| format!("{} %", fixed(100.0 * (r.time_ratio - 1.0), 0));
    study.columns(
        "With the omission, and what it changes",
        &rows,
        &[
            ("scene", &|r| r.scene.clone()),
            ("omission", &|r| r.omission.into()),
            ("time [us]", &|r| three_digits(r.total_us)),
            ("change", &change),
            ("paths", &|r| three_digits(r.paths_per_link)),
            ("left out", &|r| three_digits(r.left_out_per_link)),
            ("mean error [dB]", &|r| small(r.mean_error_db)),
            ("worst link [dB]", &|r| small(r.worst_error_db)),
            ("links lost", &|r| r.lost_links.to_string()),
        ],
    );
    let caption = "Time with an omission in parts of that without it, and what it costs; costs below 1e\u{2212}6 dB are drawn there.";
    study.figure("omissions", caption, chart(&rows).draw());
    study.data("omissions", "Every omission in every scene", &rows)
}

fn chart(rows: &[Row]) -> Chart {
    let x = Axis::linear("time, in parts of that without the omission");
    let chart = Chart::new(x, Axis::log("mean error [dB]")).sized(640.0, 440.0);
    let names = omissions().into_iter().flat_map(|(_, ranges)| ranges);
    names.fold(chart, |chart, (name, _)| {
        let own = rows.iter().filter(|r| r.omission == name);
        let spot = |r: &Row| Spot {
            at: [r.time_ratio, r.mean_error_db.max(1e-6)],
            // Where nothing is lost the names would only cover each other.
            label: match r.mean_error_db > 1e-6 {
                true => r.scene.clone(),
                false => String::new(),
            },
            ..Spot::default()
        };
        chart.spots(name, own.map(spot).collect::<Vec<_>>())
    })
}

fn of_scene(setup: &Setup, (tx, rx): (usize, usize), place: &NamedScene) -> Result<Vec<Row>> {
    let links = Links::draw(place, setup.seed, tx, rx)?;
    let stopwatch = Stopwatch::of(setup.profile);
    let per_link = |count: usize| count as f64 / links.len() as f64;
    let mut rows = Vec::new();
    for (all, ranges) in omissions() {
        let with = |(_, range_db)| TraceConfig {
            dynamic_range_db: Some(range_db),
            ..all.clone()
        };
        let with = ranges.map(with);
        let configs: Vec<&TraceConfig> = iter::once(&all).chain(&with).collect();
        let mut measured = links.measure(&configs, stopwatch)?.into_iter();
        let without = measured.next().context("every setting is measured")?;
        let scorer = ReferenceScorer::new(without.spectra)?;
        for ((omission, _), with) in ranges.into_iter().zip(measured) {
            let scores = scorer.score(&with.spectra)?;
            rows.push(Row {
                scene: place.name.clone(),
                walls: place.scene.walls().len(),
                convex_corners: place.convex_corners(),
                omission,
                links: links.len(),
                compared: scores.links,
                paths_per_link: per_link(with.paths),
                left_out_per_link: per_link(with.omitted.by_bound + with.omitted.by_gain),
                total_us: with.time.total_us(),
                trace_us: with.time.trace_us(),
                label_us: with.time.label_us,
                time_ratio: with.time.total_us() / without.time.total_us(),
                lost_links: scores.missing,
                mean_error_db: scores.mean_db,
                p95_error_db: scores.p95_db,
                worst_error_db: scores.worst_db,
            });
        }
    }
    Ok(rows)
}
