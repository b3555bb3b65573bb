//! The worked example of docs/protocol.md: a linear array hears one path from 30 deg and shows
//! equal lobes at 30 and 150 deg; a hair decides which is the higher.

use aps_metrics::Protocol;

use crate::common::{dominant_bins, score};

/// Lobes of 4 deg standard deviation at the given azimuths \[deg\] and heights, on the paper's
/// grid, mean removed.
fn lobes(lobes: &[(f64, f64)]) -> Vec<f64> {
    let value = |bin: usize| {
        let azimuth = -180.0 + 2.0 * bin as f64;
        lobes
            .iter()
            .map(|(at, height)| height * (-((azimuth - at) / 4.0).powi(2) / 2.0).exp())
            .sum()
    };
    let linear: Vec<f64> = (0..180).map(value).collect();
    let mean = linear.iter().sum::<f64>() / 180.0;
    linear.iter().map(|v| v - mean).collect()
}

#[test]
fn a_perfect_shape_with_swapped_twins() {
    let truth = lobes(&[(30.0, 1.0), (150.0, 0.99)]);
    let prediction = lobes(&[(30.0, 0.99), (150.0, 1.0)]);
    assert_eq!(dominant_bins(&truth, Protocol::Paper), [105, 165]);

    let scores = score(Protocol::Paper, &truth, &prediction);
    assert!(scores.cosine > 0.9999);
    assert_eq!((scores.ple_deg, scores.recall), (0.0, [1.0, 1.0]));
    assert_eq!(scores.top_error_deg, Some(120.0));
    assert!(!scores.hit(2.0) && !scores.hit(4.0));
    assert_eq!(scores.mirror_top_error_deg, Some(0.0));
    assert!(scores.mirror_hit(2.0));
}

#[test]
fn a_prediction_with_only_the_twin() {
    let truth = lobes(&[(30.0, 1.0), (150.0, 0.99)]);
    let scores = score(Protocol::Paper, &truth, &lobes(&[(152.0, 1.0)]));
    assert_eq!((scores.ple_deg, scores.recall), (62.0, [0.5, 0.5]));
    assert_eq!(scores.mirror_ple_deg, 2.0);
    assert!(!scores.hit(4.0) && scores.mirror_hit(2.0));
}
