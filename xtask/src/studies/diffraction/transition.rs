//! The transition function by itself.

use anyhow::Result;
use aps_tests::utd::transition_table;
use serde::Serialize;

use super::methods::{TRANSITIONS, Transition};
use crate::benchmark::words::three_digits;
use crate::chart::{Axis, Chart};
use crate::studies::trade::{Marked, Trade, small};
use crate::studies::{Setup, Stopwatch, Study, on_one_thread};

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
    let timings = on_one_thread(|| Stopwatch::of(setup.profile).compare(&TRANSITIONS, work))?;
    let (mut trade, mut cells) = (Trade::default(), Vec::new());
    for ((way, f), timing) in TRANSITIONS.into_iter().zip(timings) {
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
        let ns = timing.per(table.len()).ns();
        trade.add(way, way, ns, worst.relative_error);
        cells.push(vec![
            way.into(),
            three_digits(ns),
            small(worst.relative_error),
            small(worst.x),
        ]);
        rows.extend(errors);
    }
    study.heading("The transition function");
    study.text(format!(
        "F(x) at {} places from 1e\u{2212}9 to 1e9 against values of 40 digits. \"Three pieces\" is the usual mixture of a short series, a \
         table of eight values and an asymptotic series.",
        table.len()
    ));
    let of = |way: &str| -> Vec<[f64; 2]> {
        // What no double could do better is drawn at its resolution.
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
        &chart.draw(),
    );
    let chart = trade.chart(
        "time of F [ns]",
        "largest relative error of F",
        1e-17,
        Marked::All,
    );
    study.figure(
        "transition-time",
        "Largest error of the transition function against its time. Grey: the front.",
        &chart.draw(),
    );
    let head = ["way", "time [ns]", "largest relative error", "at x ="];
    study.table("Ways to the transition function", &head, cells);
    if let (Some(own), Some(usual)) = (trade.named("aps-raytrace"), trade.named("three pieces")) {
        study.text(format!(
            "aps-raytrace's takes {} ns where the usual one takes {}; its largest error is {} times smaller.",
            three_digits(own.time),
            three_digits(usual.time),
            small(usual.error / own.error)
        ));
    }
    study.data("transition", "Errors of the transition function", &rows)
}
