//! Metrics and their values as people read them.

use aps_metrics::{Better, Estimate, Metric};

use crate::numbers::fixed;

/// A value of a metric with as many digits as the paper prints, without unit.
pub fn value(metric: Metric, value: f64) -> String {
    fixed(value, metric.decimals())
}

/// The heading of a metric with its unit and an arrow that points to the better side.
pub fn heading(metric: Metric) -> String {
    let arrow = match metric.better() {
        Better::Lower => '\u{2193}',
        Better::Higher => '\u{2191}',
    };
    format!("{}\u{a0}{arrow}", metric.heading())
}

/// A mean, and its interval in a line below.
pub fn estimate(metric: Metric, of: &Estimate) -> String {
    let [mean, low, high] = [of.mean, of.low, of.high].map(|x| value(metric, x));
    format!("{mean}\n{low}\u{2026}{high}")
}

/// A cell that says there is nothing, where there is nothing.
pub fn or_nothing(text: Option<String>) -> String {
    text.unwrap_or_else(|| "\u{2013}".into())
}
