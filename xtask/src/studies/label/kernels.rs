//! The same label by other kernels and in other precisions.
//!
//! All of them take the maximum over the published 128 delays, so that nothing but rounding is different.

use anyhow::Result;
use aps_label::{DelayAxis, Label, LabelConfig, Labeler, PathSample, Scratch};
use aps_tests::double_double::DoubleDouble;
use serde::Serialize;

use super::number::Number;
use crate::benchmark::words::three_digits;
use crate::studies::errors::SpectrumError;
use crate::studies::trade::{Trade, small};
use crate::studies::{Setup, Stopwatch, Study, on_one_thread};

const ELEMENTS: usize = 16;
const SPACING: f64 = 0.5;
const RATE_HZ: f64 = 200e6;

/// The ways to a label.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kernel {
    /// Every term of Q by the formula: delays x angles x paths sines.
    Direct,
    /// Pulse and array response as two thin matrices, then their product.
    Product,
    /// The same, its sines by recurrence: along the axis for the pulse, over the elements for the array.
    Recurrence,
}

#[derive(Debug, Serialize)]
struct Row {
    kernel: String,
    precision: &'static str,
    ns_per_label: f64,
    mean_error_db: f64,
    worst_error_db: f64,
    /// Largest error of any bin, in parts of the label's maximum.
    worst_of_peak: f64,
}

/// Delays and directions of the grid.
struct Grid {
    delays_s: Vec<f64>,
    /// In the sense of the paths' angles [rad].
    angles_rad: Vec<f64>,
}

pub fn study(setup: &Setup, links: &[Vec<PathSample>], study: &mut Study) -> Result<()> {
    let config = LabelConfig::released();
    let labeler = Labeler::new(&config)?;
    let grid = Grid {
        delays_s: labeler.delays_s().to_vec(),
        angles_rad: labeler
            .angles_deg()
            .iter()
            .map(|a| a.to_radians() - std::f64::consts::PI)
            .collect(),
    };
    // The term-by-term kernels are slow.
    let links = &links[..links.len().min(setup.profile.choose(2, 16))];
    let truth: Vec<Vec<f64>> = links
        .iter()
        .map(|paths| spectrum::<DoubleDouble>(Kernel::Product, &grid, paths))
        .collect();
    let stopwatch = Stopwatch::of(setup.profile);
    let mut rows = Vec::new();
    for kernel in [Kernel::Direct, Kernel::Product, Kernel::Recurrence] {
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
        trade.add(group, name, row.ns_per_label, row.worst_of_peak);
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
        "time a label [ns]",
        "largest error [parts of the maximum]",
        1e-18,
        &[],
    );
    let caption = "Largest rounding error of a label, in parts of its maximum, against time a label. Grey: the front.";
    let mut chart = chart;
    for series in &mut chart.series {
        if let crate::chart::Mark::Spots(spots) = &mut series.mark {
            for (spot, choice) in spots
                .iter_mut()
                .zip(trade.choices.iter().filter(|c| c.group == series.name))
            {
                spot.label = choice.name.clone();
            }
        }
    }
    study.figure("kernels-time", caption, &chart.draw());
    study.points(findings(&rows));
    let cells = |row: &Row| {
        vec![
            row.kernel.clone(),
            row.precision.into(),
            three_digits(row.ns_per_label),
            small(row.mean_error_db),
            small(row.worst_error_db),
            small(row.worst_of_peak),
        ]
    };
    let head = [
        "kernel",
        "precision",
        "time a label [ns]",
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
            "aps-label takes {} ns, {} times less than the formula term by term in f64 and {} times less than the same product in plain \
             loops, and is off by {} of the maximum; they are off by {} and {}.",
            three_digits(own.ns_per_label),
            three_digits(direct.ns_per_label / own.ns_per_label),
            three_digits(product.ns_per_label / own.ns_per_label),
            small(own.worst_of_peak),
            small(direct.worst_of_peak),
            small(product.worst_of_peak)
        ));
    }
    for kernel in ["direct", "product", "recurrence"] {
        if let (Some(single), Some(double)) = (find(kernel, "f32"), find(kernel, "f64")) {
            points.push(format!(
                "{kernel} in f32 takes {} % of its time in f64, and is off by up to {} dB above \u{2212}40 dB instead of {}.",
                three_digits(100.0 * single.ns_per_label / double.ns_per_label),
                small(single.worst_error_db),
                small(double.worst_error_db)
            ));
        }
    }
    if let (Some(product), Some(recurrence)) = (find("product", "f64"), find("recurrence", "f64")) {
        points.push(format!(
            "Recurrence in f64 takes {} % of the time of the plain product and multiplies its error by {}.",
            three_digits(100.0 * recurrence.ns_per_label / product.ns_per_label),
            three_digits(recurrence.worst_of_peak / product.worst_of_peak)
        ));
    }
    if let Some(exact) = find("product", "double-double") {
        points.push(format!(
            "Double-double takes {} times as long as aps-label: digits that an input in f64 does not have.",
            three_digits(exact.ns_per_label / own.ns_per_label)
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
    let name = match kernel {
        Kernel::Direct => "direct",
        Kernel::Product => "product",
        Kernel::Recurrence => "recurrence",
    };
    Ok(row(
        name,
        precision,
        timing.per(links.len()).ns(),
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
    Ok(row(OWN, "f64", timing.per(links.len()).ns(), truth, &found))
}

fn row(
    kernel: &str,
    precision: &'static str,
    ns_per_label: f64,
    truth: &[Vec<f64>],
    found: &[Vec<f64>],
) -> Row {
    let (mut mean, mut worst, mut of_peak) = (0.0, 0.0_f64, 0.0_f64);
    for (truth, found) in truth.iter().zip(found) {
        let error = SpectrumError::of(truth, Some(found));
        mean += error.mean_db / found.len().max(1) as f64;
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
        ns_per_label,
        mean_error_db: mean,
        worst_error_db: worst,
        worst_of_peak: of_peak,
    }
}

/// The maximum of Q over the delays, in every direction [dB].
fn spectrum<T: Number>(kernel: Kernel, grid: &Grid, paths: &[PathSample]) -> Vec<f64> {
    let best: Vec<T> = match kernel {
        Kernel::Direct => direct(grid, paths),
        Kernel::Product => product(grid, paths, pulses_direct, |psi: T| {
            let below = psi.sin_pi();
            (T::of(ELEMENTS as f64) * psi).sin_pi() / (T::of(ELEMENTS as f64) * below)
        }),
        Kernel::Recurrence => product(grid, paths, pulses_by_rotation, dirichlet_by_recurrence),
    };
    best.into_iter()
        .map(|power| decibel(power.to_f64()))
        .collect()
}

fn decibel(power: f64) -> f64 {
    10.0 * (power + 1e-35).log10()
}

/// pi d (sin theta - sin theta_k) in half turns.
fn half_turns<T: Number>(theta: f64, path: &PathSample) -> T {
    T::of(SPACING) * (T::of(theta).sin() - T::of(path.arrival_azimuth_rad).sin())
}

fn power<T: Number>(path: &PathSample) -> T {
    T::of(10_f64.powf(0.1 * path.gain_db))
}

pub(super) fn squared_sinc<T: Number>(x: T) -> T {
    if x == T::of(0.0) {
        return T::of(1.0);
    }
    let sinc = x.sin_pi() / (T::of(std::f64::consts::PI) * x);
    sinc * sinc
}

fn direct<T: Number>(grid: &Grid, paths: &[PathSample]) -> Vec<T> {
    let n = T::of(ELEMENTS as f64);
    let maximum = |&theta: &f64| {
        let mut best = T::of(0.0);
        for &tau in &grid.delays_s {
            let mut sum = T::of(0.0);
            for path in paths {
                let psi = half_turns::<T>(theta, path);
                let below = psi.sin_pi();
                let response = match below == T::of(0.0) {
                    true => T::of(1.0),
                    false => (n * psi).sin_pi() / (n * below),
                };
                let x = T::of(RATE_HZ) * (T::of(tau) - T::of(path.delay_s));
                sum = sum + power::<T>(path) * squared_sinc(x) * response * response;
            }
            best = if sum > best { sum } else { best };
        }
        best
    };
    grid.angles_rad.iter().map(maximum).collect()
}

fn product<T: Number>(
    grid: &Grid,
    paths: &[PathSample],
    pulses: impl Fn(&Grid, &PathSample) -> Vec<T>,
    dirichlet: impl Fn(T) -> T,
) -> Vec<T> {
    let pulses: Vec<Vec<T>> = paths.iter().map(|path| pulses(grid, path)).collect();
    let maximum = |&theta: &f64| {
        let weight = |path: &PathSample| {
            let psi = half_turns::<T>(theta, path);
            let response = match psi.sin_pi() == T::of(0.0) {
                true => T::of(1.0),
                false => dirichlet(psi),
            };
            power::<T>(path) * response * response
        };
        let weights: Vec<T> = paths.iter().map(weight).collect();
        let mut sums = vec![T::of(0.0); grid.delays_s.len()];
        for (row, &weight) in pulses.iter().zip(&weights) {
            for (sum, &pulse) in sums.iter_mut().zip(row) {
                *sum = *sum + weight * pulse;
            }
        }
        sums.into_iter()
            .fold(T::of(0.0), |best, sum| if sum > best { sum } else { best })
    };
    grid.angles_rad.iter().map(maximum).collect()
}

pub(super) fn pulse_places<T: Number>(delays_s: &[f64], delay_s: f64) -> impl Iterator<Item = T> {
    delays_s
        .iter()
        .map(move |&tau| T::of(RATE_HZ) * (T::of(tau) - T::of(delay_s)))
}

fn pulses_direct<T: Number>(grid: &Grid, path: &PathSample) -> Vec<T> {
    pulse_places(&grid.delays_s, path.delay_s)
        .map(squared_sinc)
        .collect()
}

fn pulses_by_rotation<T: Number>(grid: &Grid, path: &PathSample) -> Vec<T> {
    rotated_pulses(&grid.delays_s, path.delay_s)
}

/// The sines of equally spaced arguments, each from the one before by a rotation.
pub(super) fn rotated_pulses<T: Number>(delays_s: &[f64], delay_s: f64) -> Vec<T> {
    let step = T::of(RATE_HZ) * T::of(delays_s[1] - delays_s[0]);
    let (step_sin, step_cos) = (step.sin_pi(), step.cos_pi());
    let first = T::of(RATE_HZ) * (T::of(delays_s[0]) - T::of(delay_s));
    let (mut sin, mut cos) = (first.sin_pi(), first.cos_pi());
    let pulse = |x: T| {
        let sinc = match x == T::of(0.0) {
            true => T::of(1.0),
            false => sin / (T::of(std::f64::consts::PI) * x),
        };
        (sin, cos) = (
            sin * step_cos + cos * step_sin,
            cos * step_cos - sin * step_sin,
        );
        sinc * sinc
    };
    pulse_places(delays_s, delay_s).map(pulse).collect()
}

/// sin(N psi) / (N sin psi) as the Chebyshev polynomial of the second kind, U_{N-1}(cos psi) / N.
fn dirichlet_by_recurrence<T: Number>(psi: T) -> T {
    let twice = T::of(2.0) * psi.cos_pi();
    let (mut before, mut now) = (T::of(1.0), twice);
    for _ in 2..ELEMENTS {
        (before, now) = (now, twice * now - before);
    }
    now / T::of(ELEMENTS as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_kernels_make_the_same_label() {
        let paths = [
            PathSample {
                delay_s: 200e-9,
                arrival_azimuth_rad: 0.4,
                gain_db: -80.0,
            },
            PathSample {
                delay_s: 333e-9,
                arrival_azimuth_rad: -2.0,
                gain_db: -91.0,
            },
        ];
        let labeler = Labeler::new(&LabelConfig::released()).unwrap();
        let grid = Grid {
            delays_s: labeler.delays_s().to_vec(),
            angles_rad: labeler
                .angles_deg()
                .iter()
                .map(|a| a.to_radians() - std::f64::consts::PI)
                .collect(),
        };
        let own = labeler.label(&paths).unwrap().unwrap();
        let own: Vec<f64> = own
            .aps_db
            .iter()
            .map(|db| db - labeler.config().protocol.sent_power_db())
            .collect();
        for kernel in [Kernel::Direct, Kernel::Product, Kernel::Recurrence] {
            let found = spectrum::<f64>(kernel, &grid, &paths);
            let error = SpectrumError::of(&own, Some(&found)).worst_db;
            assert!(error < 1e-9, "{kernel:?}: {error:e} dB");
        }
        let exact = spectrum::<DoubleDouble>(Kernel::Product, &grid, &paths);
        assert!(SpectrumError::of(&own, Some(&exact)).worst_db < 1e-9);
    }
}
