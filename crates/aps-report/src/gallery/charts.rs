//! The charts of the statistics.

use super::statistics::PAPER_MEAN_PEAKS;
use crate::chart::{Axis, Chart, Histogram};
use crate::drawing::Drawing;

const HEIGHT: f64 = 250.0;
const BINS: usize = 30;

fn share(x: &str, histogram: &Histogram) -> Chart {
    let y = Axis::linear("share of the links [%]");
    let chart = Chart::new(Axis::linear(x), y).sized(480.0, HEIGHT);
    chart.histogram("", histogram)
}

/// Number of dominant peaks, with the mean here and the paper's.
pub fn dominant_peaks(peaks: &[u64]) -> Option<Drawing> {
    let histogram = Histogram::counts(peaks.iter().copied());
    let last = histogram.edges.last().copied()?;
    let mean = peaks.iter().sum::<u64>() as f64 / peaks.len().max(1) as f64;
    let mut chart = share("dominant peaks", &histogram);
    chart.x = chart.x.over(histogram.edges[0], last).every(1.0);
    // The names of two lines at almost one place would cover each other.
    let name = format!("mean {mean:.2}, paper {PAPER_MEAN_PEAKS}");
    (!peaks.is_empty()).then(|| chart.rule(name, mean).draw())
}

/// Distances \[m\].
pub fn distance(values: &[f64]) -> Drawing {
    share("distance [m]", &Histogram::around(values, BINS)).draw()
}

/// Numbers of paths.
pub fn paths(counts: &[u64]) -> Drawing {
    let last = counts.iter().copied().max().unwrap_or(0);
    let histogram = match last <= 60 {
        true => Histogram::counts(counts.iter().copied()),
        false => {
            let values: Vec<f64> = counts.iter().map(|&n| n as f64).collect();
            Histogram::around(&values, BINS)
        }
    };
    share("paths", &histogram).draw()
}

/// Path losses \[dB\].
pub fn path_loss(values: &[f64]) -> Drawing {
    share("path loss [dB]", &Histogram::around(values, BINS)).draw()
}

/// Delay spreads \[ns\], up to that of all but one link in a hundred.
pub fn delay_spread(values: &[f64]) -> Drawing {
    let mut sorted: Vec<f64> = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let last = sorted.len() * 99 / 100;
    sorted.truncate(last.max(1));
    let round = Histogram::around(&sorted, BINS);
    let (first, last) = (round.edges[0], round.edges[round.edges.len() - 1]);
    let all = Histogram::of(values.iter().copied(), first, last, round.counts.len());
    share("delay spread [ns]", &all).draw()
}
