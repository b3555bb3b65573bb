//! Rounding: the worst error of each kernel in ulps, against 32 digits.

use anyhow::Result;
use aps_tests::ulps::{KernelError, worst_errors};
use serde::Serialize;

use super::{Study, StudyName};
use crate::benchmark::words;

#[derive(Debug, Serialize)]
struct Row {
    of: &'static str,
    kernel: &'static str,
    relative_ulps: f64,
    absolute_ulps: f64,
    at: String,
    points: usize,
}

impl From<KernelError> for Row {
    fn from(error: KernelError) -> Self {
        Self {
            of: error.of,
            kernel: error.kernel,
            relative_ulps: error.relative_ulps,
            absolute_ulps: error.absolute_ulps,
            at: error.at,
            points: error.points,
        }
    }
}

/// Measures; the same for every profile, since it takes seconds.
pub fn run() -> Result<Study> {
    let mut rows: Vec<Row> = worst_errors().into_iter().map(Row::from).collect();
    rows.sort_by(|p, q| q.absolute_ulps.total_cmp(&p.absolute_ulps));
    let mut study = Study::new(
        StudyName::Rounding.name(),
        "Rounding: the worst of each kernel",
    )
    .at(6);
    study.text(
        "Fixed arguments over each kernel's range, against the same formula in double-double arithmetic (32 digits), so that \
         rounding and approximations inside a kernel show, not the physics it stands for. An ulp is 2.2e\u{2212}16: of the value \
         itself where that is at least 1e\u{2212}6 of full scale, and of full scale anywhere.",
    );
    let few = 16.0;
    let (within, beyond): (Vec<&Row>, Vec<&Row>) =
        rows.iter().partition(|row| row.absolute_ulps <= few);
    let mut points = vec![format!(
        "{} of {} kernels stay within {few} ulps of full scale.",
        within.len(),
        rows.len()
    )];
    points.extend(beyond.iter().map(|row| {
        format!(
            "{} ({}) loses up to {} ulps, {} of full scale.",
            row.kernel,
            row.of,
            words::three_digits(row.absolute_ulps),
            super::small(row.absolute_ulps * f64::EPSILON)
        )
    }));
    study.points(points);
    let cells = |row: &Row| {
        vec![
            row.of.into(),
            row.kernel.into(),
            words::three_digits(row.relative_ulps),
            words::three_digits(row.absolute_ulps),
            row.at.clone(),
            row.points.to_string(),
        ]
    };
    let head = [
        "crate",
        "kernel",
        "worst of the value [ulp]",
        "worst of full scale [ulp]",
        "the former at",
        "points",
    ];
    study.table(
        "Kernels, the worst first",
        &head,
        rows.iter().map(cells).collect(),
    );
    study.data("kernels", "Every kernel", &rows)?;
    Ok(study)
}
