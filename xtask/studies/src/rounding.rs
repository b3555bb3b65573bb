//! Rounding: the worst error of each kernel in ulps, against 32 digits.

use anyhow::Result;
use aps_report::document::Verdict;
use aps_report::numbers::three_digits;
use aps_tests::ulps::{KernelError, worst_errors};
use serde::Serialize;

use crate::{Study, StudyName};

/// Largest error of a kernel that rounds alone, of full scale: that of the transition function, of ten digits and more.
const ROUNDED: f64 = 1e-10;

/// The kernel that ends a search at a tolerance, and the error that aps-label states for it, of full scale: 1e-6 dB.
const SEARCHED: (&str, f64) = ("maximum over a continuous delay", 2.3e-7);

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
        &StudyName::Rounding.name(),
        "Rounding: the worst of each kernel",
    )
    .at(6);
    let (name, error) = SEARCHED;
    for (is_searched, claim, most) in [
        (
            false,
            "error of every kernel that searches nothing, of full scale",
            ROUNDED,
        ),
        (
            true,
            "error of the maximum over a continuous delay, of full scale",
            error,
        ),
    ] {
        let rows = rows
            .iter()
            .filter(|row| (row.kernel == name) == is_searched);
        let ulps = rows.map(|row| row.absolute_ulps).reduce(f64::max);
        let worst = ulps.unwrap_or(f64::INFINITY) * f64::EPSILON;
        study
            .section
            .verdict(Verdict::bound(claim, worst, most, ""));
    }
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
