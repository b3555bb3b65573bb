//! The same label by plain loops, in several precisions.

use anyhow::Result;
use aps_label::{Label, LabelConfig, Labeler, PathSample, Scratch};
use aps_report::document::Verdict;
use aps_report::numbers::small;
use aps_report::numbers::three_digits;
use aps_report::trade::{Marked, Trade};
use aps_tests::double_double::DoubleDouble;
use serde::Serialize;

use super::kernels::{Grid, spectrum};
use super::number::Number;
use crate::errors::SpectrumError;
use crate::{Setup, Stopwatch, Study, on_one_thread};

#[derive(Debug, Serialize)]
struct Row {
    kernel: String,
    precision: &'static str,
    us_per_label: f64,
    mean_error_db: f64,
    worst_error_db: f64,
    /// Largest error of any bin, in parts of the label's maximum.
    worst_of_peak: f64,
}

pub fn study(setup: &Setup, links: &[Vec<PathSample>], study: &mut Study) -> Result<()> {
    let config = LabelConfig::released();
    let labeler = Labeler::new(&config)?;
    let grid = Grid::of(&labeler);
    // Double-double is slow.
    let links = &links[..links.len().min(setup.profile.choose(2, 16))];
    let truth: Vec<Vec<f64>> = links
        .iter()
        .map(|paths| spectrum::<DoubleDouble>(&grid, paths))
        .collect();
    let stopwatch = Stopwatch::of(setup.profile);
    let mut rows = vec![
        measure::<f32>("f32", &grid, links, &truth, stopwatch)?,
        measure::<f64>("f64", &grid, links, &truth, stopwatch)?,
        measure::<DoubleDouble>("double-double", &grid, links, &truth, stopwatch)?,
    ];
    rows.push(own(&labeler, links, &truth, stopwatch)?);
    let mut trade = Trade::default();
    for row in rows.iter().filter(|r| r.precision != "double-double") {
        let group = if row.kernel == OWN {
            OWN
        } else {
            row.precision
        };
        let name = match row.kernel == OWN {
            true => OWN.to_owned(),
            false => row.precision.to_owned(),
        };
        trade.add(group, name, row.us_per_label, row.worst_of_peak);
    }
    study.section.heading("Precision");
    let chart = trade.chart(
        "time a label [us]",
        "largest error [parts of the maximum]",
        1e-18,
        Marked::All,
    );
    let caption = "Largest rounding error of a label, in parts of its maximum, against time a label. Grey: the front.";
    study.figure("kernels-time", caption, chart.draw());
    let own = rows.last().map_or(0.0, |row| row.worst_of_peak);
    let claim = "rounding of aps-label, in parts of the maximum";
    study.section.verdict(Verdict::bound(claim, own, 1e-13, ""));
    let own_us = rows.last().map_or(1.0, |row| row.us_per_label);
    let cells = |row: &Row| {
        vec![
            row.kernel.clone(),
            row.precision.into(),
            three_digits(row.us_per_label),
            small(row.mean_error_db),
            small(row.worst_error_db),
            small(row.worst_of_peak),
            three_digits(row.us_per_label / own_us),
        ]
    };
    let head = [
        "kernel",
        "precision",
        "time a label [us]",
        "mean error [dB]",
        "largest error [dB]",
        "largest error [of the maximum]",
        "times as long as aps-label",
    ];
    study.table(
        "Plain loops in several precisions, against double-double (32 digits)",
        &head,
        rows.iter().map(cells).collect(),
    );
    study.data("kernels", "Every precision", &rows)
}

const OWN: &str = "aps-label";

fn measure<T: Number + Send>(
    precision: &'static str,
    grid: &Grid,
    links: &[Vec<PathSample>],
    truth: &[Vec<f64>],
    stopwatch: Stopwatch,
) -> Result<Row> {
    let found: Vec<Vec<f64>> = links
        .iter()
        .map(|paths| spectrum::<T>(grid, paths))
        .collect();
    let timing = on_one_thread(|| {
        stopwatch.time(|| {
            for paths in links {
                std::hint::black_box(spectrum::<T>(grid, paths));
            }
        })
    })?;
    Ok(row(
        "plain loops",
        precision,
        timing.per(links.len()).us(),
        truth,
        &found,
    ))
}

fn own(
    labeler: &Labeler,
    links: &[Vec<PathSample>],
    truth: &[Vec<f64>],
    stopwatch: Stopwatch,
) -> Result<Row> {
    let (mut scratch, mut label) = (Scratch::default(), Label::default());
    let mut found = Vec::new();
    for paths in links {
        let _ = labeler.label_into(paths, &mut scratch, &mut label)?;
        // The reference knows no power sent.
        let sent = labeler.config().protocol.sent_power_db();
        found.push(label.aps_db.iter().map(|db| db - sent).collect());
    }
    let timing = on_one_thread(|| {
        stopwatch.time(|| {
            for paths in links {
                let _ = std::hint::black_box(labeler.label_into(paths, &mut scratch, &mut label));
            }
        })
    })?;
    Ok(row(OWN, "f64", timing.per(links.len()).us(), truth, &found))
}

fn row(
    kernel: &str,
    precision: &'static str,
    us_per_label: f64,
    truth: &[Vec<f64>],
    found: &[Vec<f64>],
) -> Row {
    let links = truth.len() as f64;
    let (mut mean, mut worst, mut of_peak) = (0.0, 0.0_f64, 0.0_f64);
    for (truth, found) in truth.iter().zip(found) {
        let error = SpectrumError::of(truth, Some(found));
        mean += error.mean_db / links;
        worst = worst.max(error.worst_db);
        let top = truth.iter().copied().fold(f64::MIN, f64::max);
        for (t, f) in truth.iter().zip(found) {
            let linear = |db: f64| 10_f64.powf(0.1 * (db - top));
            // The difference of two values in dB keeps the digits that the difference of powers loses.
            let error = linear(*t) * (0.1 * (f - t) * std::f64::consts::LN_10).exp_m1().abs();
            of_peak = of_peak.max(error);
        }
    }
    Row {
        kernel: kernel.into(),
        precision,
        us_per_label,
        mean_error_db: mean,
        worst_error_db: worst,
        worst_of_peak: of_peak,
    }
}
