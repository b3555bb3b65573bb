//! The tables of a report.

mod comparisons;
mod costs;
mod scores;

pub use comparisons::{against, groups};
pub use costs::{front, times, trade, training};
pub use scores::{ABLATION, DIRECTIONS, MAIN, scores, with_cost, with_parts};

use super::results::EntryKind;

/// A kind as a word in CSV.
fn kind(kind: EntryKind) -> &'static str {
    match kind {
        EntryKind::Model => "model",
        EntryKind::Ablation => "ablation",
        EntryKind::Baseline => "baseline",
        EntryKind::Tracer => "tracer",
        EntryKind::External => "external",
    }
}
