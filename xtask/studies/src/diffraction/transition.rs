//! The transition function by itself.

use anyhow::Result;
use aps_report::chart::{Axis, Chart};
use aps_report::document::Verdict;
use aps_report::numbers::{small, three_digits};
use aps_report::trade::Trade;
use aps_tests::utd::transition_table;
use serde::Serialize;

use super::methods::{TRANSITIONS, Transition};
use crate::{Setup, Stopwatch, Study};

#[derive(Debug, Clone, Serialize)]
struct Row {
    way: &'static str,
    x: f64,
    relative_error: f64,
}

pub fn study(setup: &Setup, study: &mut Study) -> Result<()> {
    let table = transition_table();
    let mut rows = Vec::new();
    let work = |&(_, f): &(&str, Transition)| {
        for &(x, _) in &table {
            std::hint::black_box(f(std::hint::black_box(x)));
        }
    };
    let times = Stopwatch::of(setup.profile).each(&TRANSITIONS, table.len(), work)?;
    let (mut trade, mut cells) = (Trade::default(), Vec::new());
    for ((way, f), seconds) in TRANSITIONS.into_iter().zip(times) {
        let errors = table.iter().map(|&(x, exact)| Row {
            way,
            x,
            relative_error: (f(x) - exact).norm() / exact.norm(),
        });
        let errors: Vec<Row> = errors.collect();
        let worst = errors
            .iter()
            .max_by(|p, q| p.relative_error.total_cmp(&q.relative_error));
        let Some(worst) = worst else { continue };
        let ns = 1e9 * seconds;
        trade.add(way, way, ns, worst.relative_error);
        cells.push(vec![
            way.into(),
            three_digits(ns),
            small(worst.relative_error),
            small(worst.x),
        ]);
        rows.extend(errors);
    }
    study.section.heading("The transition function");
    let of = |way: &str| -> Vec<[f64; 2]> {
        // Errors below a double's resolution are drawn at that resolution.
        let own = rows.iter().filter(|r| r.way == way);
        own.map(|r| [r.x, r.relative_error.max(1e-17)]).collect()
    };
    let chart = Chart::new(Axis::log("x"), Axis::log("relative error of F")).sized(640.0, 360.0);
    let chart = TRANSITIONS
        .iter()
        .fold(chart, |chart, (way, _)| chart.line(*way, of(way)));
    study.figure(
        "transition",
        "Error of the transition function; exact values are drawn at 1e\u{2212}17.",
        chart.draw(),
    );
    let chart = trade.chart(
        "time of F [ns]",
        "largest relative error of F",
        1e-17,
        |_| true,
    );
    study.figure(
        "transition-time",
        "Largest error of the transition function against its time. Grey: the front.",
        chart.draw(),
    );
    let head = ["way", "time [ns]", "largest relative error", "at x ="];
    study.table(
        "Ways to the transition function, against 40 digits at x from 1e\u{2212}9 to 1e9",
        &head,
        cells,
    );
    if let Some(own) = trade.named("aps-raytrace") {
        let claim = "relative error of F in aps-raytrace";
        study
            .section
            .verdict(Verdict::bound(claim, own.error, 3e-11, ""));
    }
    study.data("transition", "Errors of the transition function", &rows)
}
