//! Metrics and their values as people read them.

use aps_metrics::{Estimate, Metric};

use crate::numbers::fixed;

/// Digits after the point that mean something for a metric.
fn decimals(metric: Metric) -> usize {
    match metric {
        Metric::PsnrDb | Metric::NmseDb | Metric::SpectralAngleDeg => 2,
        Metric::PleDeg | Metric::MirrorPleDeg => 2,
        _ => 3,
    }
}

/// A value of a metric, without unit.
pub fn value(metric: Metric, value: f64) -> String {
    fixed(value, decimals(metric))
}

/// The heading of a metric with its unit and an arrow that points to the better side.
pub fn heading(metric: Metric) -> String {
    let arrow = match metric.better() {
        aps_metrics::Better::Lower => '\u{2193}',
        aps_metrics::Better::Higher => '\u{2191}',
    };
    match metric.unit() {
        "" => format!("{}\u{a0}{arrow}", metric.label()),
        unit => format!("{} [{unit}]\u{a0}{arrow}", metric.label()),
    }
}

/// A metric with its unit, as the name of an axis.
pub fn axis(metric: Metric) -> String {
    match metric.unit() {
        "" => metric.label().into(),
        unit => format!("{} [{unit}]", metric.label()),
    }
}

/// `0.931 to 0.952`: an interval.
pub fn interval(metric: Metric, estimate: &Estimate) -> String {
    format!(
        "{} to {}",
        value(metric, estimate.low),
        value(metric, estimate.high)
    )
}

/// `0.931…0.952`: the same for narrow columns.
pub fn short_interval(metric: Metric, estimate: &Estimate) -> String {
    interval(metric, estimate).replace(" to ", "…")
}

/// `0.94 (0.93 to 0.95)`: a mean and its interval.
pub fn estimate(metric: Metric, estimate: &Estimate) -> String {
    format!(
        "{} ({})",
        value(metric, estimate.mean),
        interval(metric, estimate)
    )
}
