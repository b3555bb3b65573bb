//! Run times a link, of times that were measured.

use std::time::Duration;

use aps_metrics::Distribution;
use aps_report::benchmark::Latency;

/// Run times from measured times a link \[ms\], of something that needs no input and runs on the processor.
///
/// # Panics
/// If there are none.
pub fn of_times(batch: usize, ms_per_link: Vec<f64>) -> Latency {
    let times = Distribution::of(ms_per_link).expect("a time was taken");
    Latency {
        batch,
        median_ms_per_link: times.median,
        p95_ms_per_link: times.q95,
        input_ms_per_link: 0.0,
        device: "cpu".into(),
    }
}

/// The time of some links, divided by their number \[ms\].
pub fn ms_per_link(time: Duration, links: usize) -> f64 {
    time.as_secs_f64() * 1e3 / links as f64
}
