//! Rounding: the worst error of each kernel in ulps, against 32 digits.

use anyhow::Result;
use aps_report::document::Verdict;
use aps_report::numbers::three_digits;
use aps_tests::ulps::worst_errors;

use crate::{Study, StudyName};

/// Largest error of a kernel that rounds alone, of full scale: that of the transition function, of ten digits and more.
const ROUNDED: f64 = 1e-10;

/// The kernel that ends a search at a tolerance, and the error that aps-label states for it, of full scale: 1e-6 dB.
const SEARCHED: (&str, f64) = ("maximum over a continuous delay", 2.3e-7);

/// Measures; the same for every profile, since it takes seconds.
pub fn run() -> Result<Study> {
    let mut rows = worst_errors();
    rows.sort_by(|p, q| q.absolute_ulps.total_cmp(&p.absolute_ulps));
    let mut study = StudyName::Rounding.study("Rounding: the worst of each kernel");
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
    study.columns(
        "Kernels against the same formula in double-double (32 digits), the worst first; 1 ulp is 2.2e\u{2212}16",
        &rows,
        &[
            ("crate", &|row| row.of.into()),
            ("kernel", &|row| row.kernel.into()),
            ("worst of the value [ulp]", &|row| three_digits(row.relative_ulps)),
            ("worst of full scale [ulp]", &|row| three_digits(row.absolute_ulps)),
            ("the former at", &|row| row.at.clone()),
            ("points", &|row| row.points.to_string()),
        ],
    );
    study.data("kernels", "Every kernel", &rows)?;
    Ok(study)
}
