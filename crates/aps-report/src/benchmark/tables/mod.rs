//! The tables of a report.

mod comparisons;
mod costs;
mod scores;

pub use comparisons::{against, groups};
pub use costs::{front, times, trade, training};
pub use scores::{ABLATION, DIRECTIONS, MAIN, scores, with_cost, with_parts};

use super::results::EntryKind;
use crate::document::Table;

/// A table without rows: caption and headings to read, file and headings of its CSV.
fn table<S: Into<String>, K: Into<String>>(
    stem: &str,
    caption: impl Into<String>,
    head: impl IntoIterator<Item = S>,
    keys: impl IntoIterator<Item = K>,
) -> Table {
    let keys = keys.into_iter().map(Into::into).collect();
    Table::new(caption, head).with_data(format!("tables/{stem}.csv"), vec![keys])
}

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

/// A cell that says there is nothing, where there is nothing.
fn or_nothing(text: Option<String>) -> String {
    text.unwrap_or_else(|| "\u{2013}".into())
}

/// A value with all its digits; empty for none.
fn digits<T: ToString>(value: Option<T>) -> String {
    value.map(|v| v.to_string()).unwrap_or_default()
}
