//! Growth of the error of the pulse along a delay axis.

use anyhow::Result;
use aps_label::{Array, DelayAxis, LabelConfig, Labeler, PathSample};
use aps_report::chart::{Axis, Chart};
use aps_report::document::Verdict;
use aps_report::numbers::small;
use aps_tests::double_double::DoubleDouble;
use aps_tests::label::squared_sinc;
use serde::Serialize;

use super::kernels::{self, pulse_places, rotated_pulses};
use super::number::Number;
use crate::{Setup, Study};

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
    study.section.heading("Error growth along the axis");
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
        chart.draw(),
    );
    let ends = |kernel: &str| {
        let points = of(kernel);
        Some([points.first()?[1], points.last()?[1]])
    };
    let cells = |kernel: &&str| {
        let [first, last] = ends(kernel)?;
        Some(vec![
            kernel.to_string(),
            small(first),
            small(last),
            small(last / first),
        ])
    };
    let caption = "Largest error of the pulse on the shortest and on the longest axis";
    let head = ["kernel", "shortest", "longest", "times as large"];
    study.table(caption, &head, KERNELS.iter().filter_map(cells).collect());
    if let Some([first, last]) = ends("aps-label") {
        let claim = "growth of the error of aps-label along the axis";
        study
            .section
            .verdict(Verdict::bound(claim, last / first, 3.0, "times"));
    }
    study.data("pulse", "Error of the pulse on every axis", &rows)
}

fn plain<T: Number>(values: Vec<T>) -> Vec<f64> {
    values.into_iter().map(T::to_f64).collect()
}
