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
    is_error::<Error>();
}
