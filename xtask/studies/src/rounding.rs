//! Rounding: the worst error of each kernel in ulps, against 32 digits.

use anyhow::Result;
use aps_report::document::Verdict;
use aps_report::numbers::three_digits;
use aps_tests::ulps::{KernelError, worst_errors};
use serde::Serialize;

use crate::{Study, StudyName};

/// Largest error of a kernel, of full scale: that of the transition function, of ten digits and more.
const MOST: f64 = 1e-10;

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
    let worst = rows
        .first()
        .map_or(0.0, |row| row.absolute_ulps * f64::EPSILON);
    let claim = "error of every kernel, of full scale";
    study
        .section
        .verdict(Verdict::bound(claim, worst, MOST, ""));
    let cells = |row: &Row| {
        vec![
            row.of.into(),
            row.kernel.into(),
            three_digits(row.relative_ulps),
            three_digits(row.absolute_ulps),
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
        "Kernels against the same formula in double-double (32 digits), the worst first; 1 ulp is 2.2e\u{2212}16",
        &head,
        rows.iter().map(cells).collect(),
    );
    study.data("kernels", "Every kernel", &rows)?;
    Ok(study)
}
