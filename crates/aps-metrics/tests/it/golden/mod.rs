//! Against SciPy and NumPy: `tests/golden/metrics.py` of the workspace made the expected values.

mod spectra;

use aps_metrics::{Evaluation, Metric, Peak, PeakFinder, Protocol, Scorer, Spectra, Topology};
use spectra::{BINS, load, samples};

use crate::common::{peak_bins, range};
use crate::laws::peaks_by_walking;

/// The script's data range, in the unit of the spectra.
const DATA_RANGE: f64 = 16.0;

#[test]
fn prominences_of_all_local_maxima_are_equal() {
    let expected: Vec<f64> = load("prominences.npy");
    let mut finder = PeakFinder::default();
    let mut expected = expected.into_iter();
    for sample in samples() {
        for spectrum in [&sample.truth, &sample.prediction] {
            let walked = peaks_by_walking(spectrum, Topology::Line);
            let peaks: Vec<Peak> = walked.iter().map(|&(peak, _)| peak).collect();
            assert_eq!(finder.find(spectrum, Topology::Line, 0.0), peaks);
            // Exact: the spectra are small integers over 4096.
            let weighted = |(peak, prominence): &(Peak, f64)| prominence * (peak.bin + 1) as f64;
            let sum: f64 = walked.iter().map(weighted).sum();
            assert_eq!(Some(sum), expected.next(), "{}", sample.name);
        }
    }
    assert_eq!(expected.next(), None);
}

#[test]
fn peak_bins_are_equal() {
    for protocol in Protocol::ALL {
        let stored: Vec<u8> = load(&format!("peaks_{}.npy", protocol.name()));
        let mut stored = stored.into_iter().map(usize::from);
        for sample in samples() {
            for spectrum in [&sample.truth, &sample.prediction] {
                let found = peak_bins(spectrum, protocol);
                let count = stored.next().expect("a count");
                let expected: Vec<usize> = stored.by_ref().take(count).collect();
                assert_eq!(found, expected, "{protocol:?} {}", sample.name);
            }
        }
        assert_eq!(stored.next(), None);
    }
}

#[test]
fn metrics_agree_to_9_digits() {
    let pointwise: Vec<f64> = load("pointwise.npy");
    let peak_metrics: Vec<f64> = load("peak_metrics.npy");
    let samples = samples();
    assert_eq!(pointwise.len(), samples.len() * 8);
    assert_eq!(peak_metrics.len(), 2 * samples.len() * 8);
    for (protocol, peak_metrics) in Protocol::ALL
        .iter()
        .zip(peak_metrics.chunks(samples.len() * 8))
    {
        let mut scorer = Scorer::new(*protocol);
        let rows = pointwise.chunks(8).zip(peak_metrics.chunks(8));
        for (sample, (flat, peaky)) in samples.iter().zip(rows) {
            let scores = scorer
                .score(&sample.truth, &sample.prediction)
                .expect("finite");
            let expected = [&flat[..5], &peaky[..5], &flat[5..], &peaky[5..]].concat();
            for (metric, expected) in Metric::ALL.into_iter().zip(expected) {
                let found = metric.of(&scores, range(DATA_RANGE));
                assert_close(found, expected, metric, &sample.name);
            }
        }
    }
}

#[test]
fn summaries_agree_to_9_digits() {
    let expected: Vec<f64> = load("summary.npy");
    let samples = samples();
    let truth: Vec<f64> = samples.iter().flat_map(|s| s.truth.clone()).collect();
    let prediction: Vec<f64> = samples.iter().flat_map(|s| s.prediction.clone()).collect();
    let view = |values| Spectra::new(values, BINS).expect("whole rows");
    let mut expected = expected.chunks(9);
    for protocol in Protocol::ALL {
        let mut evaluation = Evaluation::new(protocol);
        evaluation
            .push(view(&truth), view(&prediction), None)
            .expect("equal shapes");
        let report = evaluation.report(range(DATA_RANGE));
        for metric in Metric::ALL {
            let d = report.overall.get(metric).expect("samples");
            let found = [
                d.mean, d.std, d.min, d.q05, d.q25, d.median, d.q75, d.q95, d.max,
            ];
            for (found, &expected) in found.into_iter().zip(expected.next().expect("a row")) {
                assert_close(found, expected, metric, "summary");
            }
        }
    }
}

/// Equal to 1e-9 relative, beyond the rounding of a cosine (found and expected sum in different
/// orders): a few 1e-16, which acos magnifies by 1 / sin, and by 1e8 next to 0 or 180 deg.
fn assert_close(found: f64, expected: f64, metric: Metric, place: &str) {
    let rounding = match metric {
        Metric::SpectralAngleDeg => (1e-15 / expected.to_radians().sin().abs())
            .min(3e-8)
            .to_degrees(),
        _ => 1e-15,
    };
    let error = (found - expected).abs();
    assert!(
        error <= rounding + 1e-9 * expected.abs(),
        "{metric:?} of {place}: {found} instead of {expected}"
    );
}
