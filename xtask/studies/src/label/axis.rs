//! The maximum over delay: on an axis of more and more points, or continuous.

use anyhow::Result;
use aps_label::{Array, DelayAxis, Label, LabelConfig, Labeler, PathSample, Scratch};
use aps_metrics::LevelDistance;
use aps_report::document::Verdict;
use aps_report::link::turn_deg;
use aps_report::numbers::{small, three_digits};
use aps_report::trade::Trade;
use rayon::prelude::*;
use serde::Serialize;

use crate::{Setup, Stopwatch, Study};

/// Points of the axis from 0 to 1000 ns; the first is the published one.
const POINTS: [usize; 8] = [128, 64, 256, 401, 512, 1024, 2048, 4096];

/// Samples of the reference per null spacing of the pulse, before the best are refined.
const FINE: f64 = 16.0;

#[derive(Debug, Default, Serialize)]
struct Row {
    axis: String,
    /// Empty for the continuous maximum.
    points: Option<usize>,
    spacing_ns: Option<f64>,
    us_per_label: f64,
    mean_error_db: f64,
    worst_error_db: f64,
}

pub fn study(setup: &Setup, links: &[Vec<PathSample>], study: &mut Study) -> Result<()> {
    let axis = |points: usize| LabelConfig {
        delay_axis: DelayAxis {
            points,
            ..DelayAxis::RELEASED
        },
        ..LabelConfig::released()
    };
    let sampled = POINTS.iter().map(|&points| Labeler::new(&axis(points)));
    let labelers = sampled.chain([Labeler::new(&LabelConfig::paper())]);
    let labelers: Vec<Labeler> = labelers.collect::<Result<_, _>>()?;
    let times = times(setup, &labelers, links)?;
    // The reference depends on the protocol, not on the axis.
    let released = references(&labelers[0], links);
    let mut rows = Vec::new();
    for ((labeler, &points), &seconds) in labelers.iter().zip(&POINTS).zip(&times) {
        let last_s = labeler.config().delay_axis.last_s;
        rows.push(Row {
            axis: format!("{points} points"),
            points: Some(points),
            spacing_ns: Some(1e9 * last_s / (points - 1) as f64),
            us_per_label: 1e6 * seconds,
            ..errors(labeler, links, &released)?
        });
    }
    let (continuous, seconds) = (&labelers[POINTS.len()], times[POINTS.len()]);
    rows.push(Row {
        axis: "continuous".into(),
        us_per_label: 1e6 * seconds,
        ..errors(continuous, links, &references(continuous, links))?
    });
    let mut trade = Trade::default();
    for row in &rows {
        let group = match row.points {
            Some(_) => "delay axis",
            None => "continuous",
        };
        trade.add(group, &row.axis, row.us_per_label, row.mean_error_db);
    }
    study.section.heading("The maximum over delay");
    let chart = trade.chart("time a label [us]", "mean error [dB]", 1e-12, |_| true);
    let caption = "Error of the maximum over delay against time a label. Grey: the front.";
    study.figure("axis-time", caption, chart.draw());
    let worst_db = rows.last().map_or(0.0, |row| row.worst_error_db);
    let claim = "error of the continuous maximum, against one refined by golden section";
    study
        .section
        .verdict(Verdict::bound(claim, worst_db, 1e-6, "dB"));
    let spacing = |row: &Row| row.spacing_ns.map_or(String::new(), three_digits);
    study.columns(
        "Delay axes",
        &rows,
        &[
            ("axis", &|row| row.axis.clone()),
            ("spacing [ns]", &spacing),
            ("time a label [us]", &|row| three_digits(row.us_per_label)),
            ("mean error [dB]", &|row| small(row.mean_error_db)),
            ("largest error [dB]", &|row| small(row.worst_error_db)),
            ("on the front", &|row| trade.on_front(&row.axis)),
        ],
    );
    study.data("axis", "Every delay axis", &rows)
}

/// Time of a label by each of the labelers [s].
fn times(setup: &Setup, labelers: &[Labeler], links: &[Vec<PathSample>]) -> Result<Vec<f64>> {
    let work = |labeler: &Labeler| {
        let (mut scratch, mut label) = (Scratch::default(), Label::default());
        for paths in links {
            let status = labeler.label_into(paths, &mut scratch, &mut label);
            let _ = std::hint::black_box(status);
        }
    };
    Stopwatch::of(setup.profile).each(labelers, links.len(), work)
}

fn errors(labeler: &Labeler, links: &[Vec<PathSample>], truth: &[Vec<f64>]) -> Result<Row> {
    let (mut mean, mut worst) = (0.0, 0.0_f64);
    for (paths, truth) in links.iter().zip(truth) {
        let label = labeler.label(paths)?.unwrap_or_default();
        let error = LevelDistance::of(truth, Some(&label.aps_db));
        mean += error.mean_db / links.len() as f64;
        worst = worst.max(error.worst_db);
    }
    Ok(Row {
        mean_error_db: mean,
        worst_error_db: worst,
        ..Row::default()
    })
}

/// The continuous maximum in every bin \[dB, in the protocol's unit\].
fn references(labeler: &Labeler, links: &[Vec<PathSample>]) -> Vec<Vec<f64>> {
    links
        .par_iter()
        .map(|paths| reference(labeler, paths))
        .collect()
}

fn reference(labeler: &Labeler, paths: &[PathSample]) -> Vec<f64> {
    let config = labeler.config();
    let rate = config.sampling_rate_hz;
    let turn_rad = turn_deg(config.protocol).to_radians();
    let ends = paths.iter().map(|p| rate * p.delay_s);
    let first = ends.clone().fold(f64::INFINITY, f64::min) - 1.0;
    let last = ends.fold(0.0, f64::max) + 1.0;
    let steps = ((last - first) * FINE).ceil() as usize;
    let place = |i: usize| first + i as f64 / FINE;
    let pulse = |u: f64, path: &PathSample| {
        let x = std::f64::consts::PI * (u - rate * path.delay_s);
        let sinc = if x == 0.0 { 1.0 } else { x.sin() / x };
        sinc * sinc
    };
    let grid: Vec<Vec<f64>> = (0..=steps)
        .map(|i| paths.iter().map(|path| pulse(place(i), path)).collect())
        .collect();
    let maximum = |theta_deg: &f64| {
        let theta = theta_deg.to_radians() - turn_rad;
        let weights: Vec<f64> = paths
            .iter()
            .map(|path| weight(&config.array, theta, path))
            .collect();
        let sum = |pulses: &[f64]| pulses.iter().zip(&weights).map(|(s, w)| s * w).sum::<f64>();
        let values: Vec<f64> = grid.iter().map(|pulses| sum(pulses)).collect();
        let at = |u: f64| {
            paths
                .iter()
                .zip(&weights)
                .map(|(path, w)| w * pulse(u, path))
                .sum::<f64>()
        };
        let peaks =
            (1..steps).filter(|&i| values[i] >= values[i - 1] && values[i] >= values[i + 1]);
        let refined = peaks.map(|i| golden_section(&at, place(i - 1), place(i + 1)));
        let best = refined.fold(0.0, f64::max);
        10.0 * best.max(1e-35).log10() + config.protocol.sent_power_db()
    };
    labeler.angles_deg().iter().map(maximum).collect()
}

fn weight(array: &Array, theta: f64, path: &PathSample) -> f64 {
    10_f64.powf(0.1 * path.gain_db) * array.power_response(theta, path.arrival_azimuth_rad)
}

/// The maximum of a function with one between two points.
fn golden_section(f: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let part = 0.5 * (5_f64.sqrt() - 1.0);
    let (mut p, mut q) = (high - part * (high - low), low + part * (high - low));
    let (mut at_p, mut at_q) = (f(p), f(q));
    // To the square root of the rounding: there the value is as good as it gets.
    for _ in 0..36 {
        if at_p > at_q {
            (high, q, at_q) = (q, p, at_p);
            p = high - part * (high - low);
            at_p = f(p);
        } else {
            (low, p, at_p) = (p, q, at_q);
            q = low + part * (high - low);
            at_q = f(q);
        }
    }
    at_p.max(at_q)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_section_finds_the_top() {
        let top = golden_section(&|x| 3.0 - (x - 0.3) * (x - 0.3), -1.0, 1.0);
        assert!((top - 3.0).abs() < 1e-13);
    }

    #[test]
    fn a_lone_path_is_at_its_own_power() {
        let path = PathSample {
            delay_s: 301.234e-9,
            arrival_azimuth_rad: 0.0,
            gain_db: -90.0,
        };
        for config in [LabelConfig::paper(), LabelConfig::released()] {
            let labeler = Labeler::new(&config).unwrap();
            let spectrum = reference(&labeler, &[path]);
            let label = labeler.label(&[path]).unwrap().unwrap();
            let top = |values: &[f64]| values.iter().copied().fold(f64::MIN, f64::max);
            // The released axis has no bin at 0 deg, and its delays miss the path.
            assert!(top(&spectrum) >= top(&label.aps_db) - 1e-9);
            assert!(top(&spectrum) <= -89.0 + 1.0 + 1e-9);
        }
    }
}
