//! The same label by other kernels and in other precisions.

use anyhow::Result;
use aps_label::{DelayAxis, Label, LabelConfig, Labeler, PathSample, Scratch};
use aps_tests::double_double::DoubleDouble;
use serde::Serialize;

use super::kernels::{Grid, Kernel, spectrum};
use super::number::Number;
use crate::benchmark::words::three_digits;
use crate::studies::errors::SpectrumError;
use crate::studies::trade::{Marked, Trade, small};
use crate::studies::{Setup, Stopwatch, Study, on_one_thread};

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
    // The term-by-term kernels are slow.
    let links = &links[..links.len().min(setup.profile.choose(2, 16))];
    let truth: Vec<Vec<f64>> = links
        .iter()
        .map(|paths| spectrum::<DoubleDouble>(Kernel::Product, &grid, paths))
        .collect();
    let stopwatch = Stopwatch::of(setup.profile);
    let mut rows = Vec::new();
    for kernel in Kernel::ALL {
        rows.push(measure::<f32>(
            kernel, "f32", &grid, links, &truth, stopwatch,
        )?);
        rows.push(measure::<f64>(
            kernel, "f64", &grid, links, &truth, stopwatch,
        )?);
    }
    rows.push(measure::<DoubleDouble>(
        Kernel::Product,
        "double-double",
        &grid,
        links,
        &truth,
        stopwatch,
    )?);
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
            false => format!("{} {}", row.kernel, row.precision),
        };
        trade.add(group, name, row.us_per_label, row.worst_of_peak);
    }
    study.heading("Precision and kernels");
    study.text(format!(
        "Q over {} delays and 180 angles for {} of these links, its maximum over delay, by plain loops: \"direct\" computes every term \
         by the formula, \"product\" multiplies two thin matrices, \"recurrence\" makes their sines by recurrence. The reference \
         is the product in double-double (32 digits). aps-label is the crate itself, with its vector code and its omissions.",
        DelayAxis::RELEASED.points,
        links.len()
    ));
    let chart = trade.chart(
        "time a label [us]",
        "largest error [parts of the maximum]",
        1e-18,
        Marked::All,
    );
    let caption = "Largest rounding error of a label, in parts of its maximum, against time a label. Grey: the front.";
    study.figure("kernels-time", caption, &chart.draw());
    study.points(findings(&rows));
    let cells = |row: &Row| {
        vec![
            row.kernel.clone(),
            row.precision.into(),
            three_digits(row.us_per_label),
            small(row.mean_error_db),
            small(row.worst_error_db),
            small(row.worst_of_peak),
        ]
    };
    let head = [
        "kernel",
        "precision",
        "time a label [us]",
        "mean error [dB]",
        "largest error [dB]",
        "largest error [of the maximum]",
    ];
    study.table(
        "Kernels and precisions",
        &head,
        rows.iter().map(cells).collect(),
    );
    study.data("kernels", "Every kernel and precision", &rows)
}

const OWN: &str = "aps-label";

fn findings(rows: &[Row]) -> Vec<String> {
    let find = |kernel: &str, precision: &str| {
        rows.iter()
            .find(|r| r.kernel == kernel && r.precision == precision)
    };
    let mut points = Vec::new();
    let Some(own) = find(OWN, "f64") else {
        return points;
    };
    if let (Some(direct), Some(product)) = (find("direct", "f64"), find("product", "f64")) {
        points.push(format!(
            "aps-label takes {} us, {} times less than the formula term by term in f64 and {} times less than the same product in plain \
             loops, and is off by {} of the maximum; they are off by {} and {}.",
            three_digits(own.us_per_label),
            three_digits(direct.us_per_label / own.us_per_label),
            three_digits(product.us_per_label / own.us_per_label),
            small(own.worst_of_peak),
            small(direct.worst_of_peak),
            small(product.worst_of_peak)
        ));
    }
    for kernel in ["direct", "product", "recurrence"] {
        if let (Some(single), Some(double)) = (find(kernel, "f32"), find(kernel, "f64")) {
            points.push(format!(
                "{kernel} in f32 takes {} % of its time in f64, and is off by up to {} dB above \u{2212}40 dB instead of {}.",
                three_digits(100.0 * single.us_per_label / double.us_per_label),
                small(single.worst_error_db),
                small(double.worst_error_db)
            ));
        }
    }
    if let (Some(product), Some(recurrence)) = (find("product", "f64"), find("recurrence", "f64")) {
        points.push(format!(
            "Recurrence in f64 takes {} % of the time of the plain product and multiplies its error by {}.",
            three_digits(100.0 * recurrence.us_per_label / product.us_per_label),
            three_digits(recurrence.worst_of_peak / product.worst_of_peak)
        ));
    }
    if let Some(exact) = find("product", "double-double") {
        points.push(format!(
            "Double-double takes {} times as long as aps-label: digits that an input in f64 does not have.",
            three_digits(exact.us_per_label / own.us_per_label)
        ));
    }
    points
}

fn measure<T: Number + Send>(
    kernel: Kernel,
    precision: &'static str,
    grid: &Grid,
    links: &[Vec<PathSample>],
    truth: &[Vec<f64>],
    stopwatch: Stopwatch,
) -> Result<Row> {
    let found: Vec<Vec<f64>> = links
        .iter()
        .map(|paths| spectrum::<T>(kernel, grid, paths))
        .collect();
    let timing = on_one_thread(|| {
        stopwatch.time(|| {
            for paths in links {
                std::hint::black_box(spectrum::<T>(kernel, grid, paths));
            }
        })
    })?;
    Ok(row(
        kernel.name(),
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
