//! Traits that every public type implements, checked by the compiler.

use std::fmt::Debug;

use aps_metrics::*;

fn is_shared<T: Debug + Clone + Send + Sync + 'static>() {}
fn is_error<T: std::error::Error + Clone + Send + Sync + 'static>() {}

#[test]
fn types_can_be_shown_copied_and_shared() {
    is_shared::<(Evaluation, Report, GroupReport, MapReport, MetricReport)>();
    is_shared::<(PeakCensus, Distribution, Metric, Definition, Protocol)>();
    is_shared::<(Scorer, SampleScores, ScoredSample, RejectedSample)>();
    is_shared::<(Bootstrap, Resamples, Estimate, PeakFinder, Peak)>();
    is_shared::<(SpectrumPeaks, Spectra<'static, f32>, DataRange)>();
    is_shared::<(Shape, Side, Defect, Better, Topology, LevelDistance)>();
    is_shared::<(AngleGrid, BinWidth, PeakScaling, RecallCandidates)>();
    is_error::<Error>();
    is_error::<UnknownProtocol>();
}

#[test]
fn names_of_protocols_are_read_back() {
    for protocol in [Protocol::Paper, Protocol::Released] {
        assert_eq!(protocol.to_string().parse(), Ok(protocol));
    }
    assert_eq!("Paper".parse(), Ok(Protocol::Paper));
    assert_eq!(
        "papier".parse::<Protocol>(),
        Err(UnknownProtocol("papier".into()))
    );
}

#[test]
#[should_panic(expected = "bins of both")]
fn levels_of_other_bins_are_not_compared() {
    let _ = LevelDistance::of(&[0.0, -1.0], Some(&[0.0]));
}
