//! How the error of the pulse grows along a delay axis.

use anyhow::Result;
use aps_label::{Array, DelayAxis, LabelConfig, Labeler, PathSample};
use aps_tests::double_double::DoubleDouble;
use aps_tests::label::squared_sinc;
use serde::Serialize;

use super::kernels::{self, pulse_places, rotated_pulses};
use super::number::Number;
use crate::chart::{Axis, Chart};
use crate::studies::trade::small;
use crate::studies::{Setup, Study};

/// Delay of the path: a number with all its digits in use.
const DELAY_S: f64 = 412.345_678_9e-9;

#[derive(Debug, Serialize)]
struct Row {
    points: usize,
    kernel: &'static str,
    /// Largest error of sinc^2 at any point, in parts of its maximum 1.
    worst_error: f64,
}

const KERNELS: [&str; 5] = [
    "recurrence f32",
    "direct f32",
    "recurrence f64",
    "direct f64",
    "aps-label",
];

pub fn study(setup: &Setup, study: &mut Study) -> Result<()> {
    let mut rows = Vec::new();
    for power in 6..=setup.profile.choose(8, 14) {
        let points = 1 << power;
        let axis = DelayAxis {
            points,
            ..DelayAxis::RELEASED
        };
        let labeler = Labeler::new(&LabelConfig {
            delay_axis: axis,
            // One element: its response is 1 everywhere.
            array: Array::UniformLinear {
                elements: 1,
                spacing_wavelengths: 0.5,
            },
            ..LabelConfig::paper()
        })?;
        let delays = labeler.delays_s();
        let places = pulse_places::<DoubleDouble>(delays, DELAY_S);
        let truth: Vec<DoubleDouble> = places.map(squared_sinc).collect();
        let path = PathSample {
            delay_s: DELAY_S,
            arrival_azimuth_rad: 0.0,
            gain_db: 0.0,
        };
        let own: Vec<f64> = delays
            .iter()
            .map(|&tau| labeler.q(&[path], tau, 0.0))
            .collect::<Result<_, _>>()?;
        let found: [Vec<f64>; 5] = [
            plain(rotated_pulses::<f32>(delays, DELAY_S)),
            plain(
                pulse_places::<f32>(delays, DELAY_S)
                    .map(kernels::squared_sinc)
                    .collect(),
            ),
            plain(rotated_pulses::<f64>(delays, DELAY_S)),
            plain(
                pulse_places::<f64>(delays, DELAY_S)
                    .map(kernels::squared_sinc)
                    .collect(),
            ),
            own,
        ];
        for (kernel, found) in KERNELS.into_iter().zip(found) {
            let error =
                |(truth, found): (&DoubleDouble, &f64)| (*truth - (*found).into()).abs().to_f64();
            let worst_error = truth.iter().zip(&found).map(error).fold(0.0, f64::max);
            rows.push(Row {
                points,
                kernel,
                worst_error,
            });
        }
    }
    study.heading("Error growth along the axis");
    let of = |kernel: &str| -> Vec<[f64; 2]> {
        let own = rows.iter().filter(|row| row.kernel == kernel);
        own.map(|row| [row.points as f64, row.worst_error])
            .collect()
    };
    let chart = Chart::new(
        Axis::log("points of the axis"),
        Axis::log("largest error of the pulse"),
    )
    .sized(640.0, 360.0);
    let chart = KERNELS
        .iter()
        .fold(chart, |chart, kernel| chart.line(*kernel, of(kernel)));
    study.figure(
        "pulse-growth",
        "Largest error of sinc\u{b2} over an axis from 0 to 1000 ns, against double-double: a recurrence carries its rounding along.",
        &chart.draw(),
    );
    study.points(
        KERNELS
            .iter()
            .filter_map(|kernel| growth(kernel, &of(kernel)))
            .collect(),
    );
    study.data("pulse", "Error of the pulse on every axis", &rows)
}

/// How the error at the end of the sweep compares with that at its beginning.
fn growth(kernel: &str, points: &[[f64; 2]]) -> Option<String> {
    let (first, last) = (points.first()?, points.last()?);
    let times = last[1] / first[1];
    let grows = match times {
        t if t > 3.0 => format!(
            "it grows by {} over {} times the points",
            small(t),
            small(last[0] / first[0])
        ),
        _ => "it does not grow with the points".into(),
    };
    Some(format!(
        "{kernel}: {} with {} points, {} with {}; {grows}.",
        small(first[1]),
        first[0],
        small(last[1]),
        last[0]
    ))
}

fn plain<T: Number>(values: Vec<T>) -> Vec<f64> {
    values.into_iter().map(T::to_f64).collect()
}
