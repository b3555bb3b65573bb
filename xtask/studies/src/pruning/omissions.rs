//! With and without each omission that can be turned off.

use anyhow::Result;
use aps_raytrace::TraceConfig;
use aps_report::chart::{Axis, Chart, Spot};
use aps_report::numbers::{fixed, small, three_digits};
use indicatif::ProgressBar;
use serde::Serialize;

use super::{convex_corners, ends};
use crate::errors::Judge;
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

/// A comparison: a name, the setting without the omission, the one with it.
struct Omission {
    name: &'static str,
    without: TraceConfig,
    with: TraceConfig,
}

/// What the range of R2 D1 leaves out, and that of the converged limits.
fn omissions() -> [Omission; 4] {
    let r2_d1 = TraceConfig::within(2, 1);
    let all = TraceConfig {
        dynamic_range_db: None,
        ..r2_d1.clone()
    };
    let range = |range_db: f64| TraceConfig {
        dynamic_range_db: Some(range_db),
        ..r2_d1.clone()
    };
    let far = TraceConfig {
        dynamic_range_db: None,
        ..TraceConfig::converged()
    };
    [
        Omission {
            name: "beyond 60 dB",
            without: all.clone(),
            with: range(60.0),
        },
        Omission {
            name: "beyond 30 dB",
            without: all,
            with: range(30.0),
        },
        Omission {
            name: "beyond 30 dB, R5 D2",
            without: far.clone(),
            with: TraceConfig {
                dynamic_range_db: Some(30.0),
                ..far.clone()
            },
        },
        Omission {
            name: "beyond 20 dB, R5 D2",
            without: far,
            with: TraceConfig::converged(),
        },
    ]
}

pub fn study(
    setup: &Setup,
    scenes: &[NamedScene],
    bar: &ProgressBar,
    study: &mut Study,
) -> Result<()> {
    let mut rows = Vec::new();
    for place in scenes {
        rows.extend(of_scene(setup, place)?);
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
    omissions().iter().fold(chart, |chart, omission| {
        let own = rows.iter().filter(|r| r.omission == omission.name);
        let spot = |r: &Row| Spot {
            at: [r.time_ratio, r.mean_error_db.max(1e-6)],
            // Where nothing is lost the names would only cover each other.
            label: match r.mean_error_db > 1e-6 {
                true => r.scene.clone(),
                false => String::new(),
            },
            ..Spot::default()
        };
        chart.spots(omission.name, own.map(spot).collect::<Vec<_>>())
    })
}

fn of_scene(setup: &Setup, place: &NamedScene) -> Result<Vec<Row>> {
    let (tx, rx) = ends(setup);
    let links = Links::draw(place, setup.seed, tx, rx)?;
    let stopwatch = Stopwatch::of(setup.profile);
    let omissions = omissions();
    let configs: Vec<&TraceConfig> = omissions
        .iter()
        .flat_map(|o| [&o.without, &o.with])
        .collect();
    let mut measured = links.measure(&configs, stopwatch)?.into_iter();
    let mut rows = Vec::new();
    for omission in &omissions {
        let (Some(without), Some(with)) = (measured.next(), measured.next()) else {
            break;
        };
        let judge = Judge::new(without.spectra)?;
        let scores = judge.score(&with.spectra)?;
        let per_link = |count: usize| count as f64 / links.len() as f64;
        rows.push(Row {
            scene: place.name.clone(),
            walls: place.scene.walls().len(),
            convex_corners: convex_corners(place),
            omission: omission.name,
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
    Ok(rows)
}
