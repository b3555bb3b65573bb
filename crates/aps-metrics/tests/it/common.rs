//! Helpers that several test files share.

use aps_metrics::{DataRange, Protocol, SampleScores, Scorer, SpectrumPeaks};

pub fn score(protocol: Protocol, truth: &[f64], prediction: &[f64]) -> SampleScores {
    let scores = Scorer::new(protocol).score(truth, prediction);
    scores.expect("finite spectra of equal length")
}

pub fn spectrum_peaks(spectrum: &[f64], protocol: Protocol) -> SpectrumPeaks {
    aps_metrics::spectrum_peaks(spectrum, &protocol.definition()).expect("finite")
}

/// Bins of all peaks.
pub fn peak_bins(spectrum: &[f64], protocol: Protocol) -> Vec<usize> {
    let peaks = spectrum_peaks(spectrum, protocol);
    peaks.all().iter().map(|peak| peak.bin).collect()
}

/// Bins of the dominant peaks.
pub fn dominant_bins(spectrum: &[f64], protocol: Protocol) -> Vec<usize> {
    let peaks = spectrum_peaks(spectrum, protocol);
    peaks.dominant().iter().map(|peak| peak.bin).collect()
}

pub fn range(range: f64) -> DataRange {
    DataRange::new(range).expect("positive")
}
