//! The benchmark's results, and the report made of them.
//!
//! Whoever runs a benchmark fills in [`Results`], writes the scores of single links with
//! [`ScoreTable`], and calls [`write_report`]. Nothing of a report is measured here: the same
//! results give the same report, also years later ([`FORMAT`]).
//!
//! ```no_run
//! use std::path::Path;
//! use aps_report::benchmark::{Results, write_report};
//!
//! let folder = Path::new("target/benchmark");
//! let results = Results::load(folder)?;
//! for file in write_report(&results, folder)? {
//!     println!("{}", file.display());
//! }
//! # Ok::<(), aps_report::ReportError>(())
//! ```

mod analysis;
mod figures;
pub mod paper;
mod report;
mod results;
mod scores;
mod tables;
mod words;

use std::path::{Path, PathBuf};

pub use results::{
    CurvePoint, DataSummary, Entry, EntryKind, Example, FILE, FORMAT, Failure, Latency, MEAN,
    Machine, Prediction, ProtocolScores, Results, TestLink, Training,
};
pub use scores::ScoreTable;

use analysis::Analysis;

use crate::ReportError;

/// Writes `report.html`, `report.md`, `tables/*.csv` and `figures/*.svg` into the folder that holds
/// the results' score files; returns the files written.
///
/// Takes seconds for ten thousands of links,
/// most of them for the intervals.
///
/// # Errors
/// Results without links, entries of the same name, score files that are missing or do not fit, or a
/// file that cannot be written.
pub fn write_report(results: &Results, folder: &Path) -> Result<Vec<PathBuf>, ReportError> {
    let analysis = Analysis::new(results, folder)?;
    report::document(&analysis).write(folder, "report")
}
