//! Traits that every public type implements, checked by the compiler.

use std::fmt::Debug;

use aps_metrics::*;

fn is_shared<T: Debug + Clone + Send + Sync + 'static>() {}
fn is_error<T: std::error::Error + Clone + Send + Sync + 'static>() {}

#[test]
fn types_can_be_shown_copied_and_shared() {
    is_shared::<Evaluation>();
    is_shared::<Report>();
    is_shared::<GroupReport>();
    is_shared::<MapReport>();
    is_shared::<MetricReport>();
    is_shared::<PeakCensus>();
    is_shared::<Distribution>();
    is_shared::<Metric>();
    is_shared::<Definition>();
    is_shared::<Protocol>();
    is_shared::<Scorer>();
    is_shared::<SampleScores>();
    is_shared::<ScoredSample>();
    is_shared::<RejectedSample>();
    is_shared::<Bootstrap>();
    is_shared::<Resamples>();
    is_shared::<Estimate>();
    is_shared::<PeakFinder>();
    is_shared::<Peak>();
    is_shared::<SpectrumPeaks>();
    is_shared::<Spectra<'static, f32>>();
    is_shared::<DataRange>();
    is_error::<Error>();
}
