//! Scores predicted angle power spectra (APS) against true ones.
//!
//! An APS is the received power over arrival azimuth, one number a bin. The Map2APS benchmark
//! scores a prediction bin by bin (MAE, MSE, RMSE, NMSE, PSNR), as a vector (cosine similarity,
//! spectral angle) and by its peaks (peak location error PLE, Hit@delta, Recall@delta). The text
//! of the paper and the Python code released with it define the peak metrics differently, and
//! numbers of one must not be compared with numbers of the other. So everything here takes a
//! [`Protocol`]: [`Protocol::Paper`], [`Protocol::Released`], or a [`Definition`] of one's own.
//!
//! The main types:
//! - [`Evaluation`] scores a test set chunk by chunk, in parallel;
//! - [`Report`] is the result: mean, standard deviation and quantiles of every [`Metric`],
//!   overall and for each map;
//! - [`Scorer`] gives the [`SampleScores`] of a single pair of spectra;
//! - [`Bootstrap`] tells how far a mean over links of few maps can be trusted;
//! - [`LevelDistance`] compares two spectra in decibels;
//! - [`PeakFinder`] finds peaks as `scipy.signal.find_peaks` does, and on a ring;
//!   [`spectrum_peaks`] tells the dominant ones.
//!
//! ```
//! use aps_metrics::{Evaluation, Metric, Protocol, Spectra};
//!
//! // Two samples of six bins, row after row, as a `.npy` file holds them.
//! let truth = [0.0_f32, 5.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 7.0, 1.0, 0.0, 0.0];
//! let prediction = [0.0_f32, 4.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 7.0, 1.0, 0.0];
//!
//! let mut evaluation = Evaluation::new(Protocol::Paper);
//! evaluation.push(Spectra::new(&truth, 6)?, Spectra::new(&prediction, 6)?, None)?;
//!
//! // PSNR is relative to the range of the truth: scanned on the way, or given.
//! let range = evaluation.truth_range().ok_or("no sample could be scored")?;
//! let report = evaluation.report(range);
//! let ple = report.overall.get(Metric::PleDeg).ok_or("no sample could be scored")?;
//! assert_eq!(ple.mean, 30.0); // The second sample's peak is one bin of 60 deg off.
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Why per-sample scores are kept
//!
//! A median cannot be merged, a list can. 120 bytes a sample buy exact quantiles, reports by map,
//! and a PSNR whose data range is known only after the last sample: PSNR is the stored squared
//! error, shifted. It also makes the result independent of threads and chunks: a sample's scores
//! depend on nothing else, and every sum over samples runs in the samples' order.
//!
//! # NaN and infinity
//!
//! No metric returned is ever NaN or infinite. A spectrum with NaN, an infinity or a value beyond
//! [`MAX_MAGNITUDE`] is not scored but listed: [`Evaluation::rejected`]. Leaving it out silently
//! would reward a model for failing on hard samples. Constant, all-negative and one-bin spectra
//! are scored; [`PeakScaling`] defines their peaks.
//!
//! # Features
//!
//! - `label` (off by default): converts a protocol of `aps-label` into a [`Protocol`].
//! - `serde` (off by default): `Serialize` for definitions, scores and reports.
//!
//! `docs/protocol.md` of the repository defines every metric in a table and works through the
//! mirror ambiguity of linear arrays.

#![forbid(unsafe_code)]

mod angle;
mod bootstrap;
mod distribution;
mod dominant;
mod error;
mod evaluation;
mod level;
mod metric;
mod peaks;
mod pointwise;
mod protocol;
mod range;
mod report;
mod sample;
mod spectra;

pub use bootstrap::{Bootstrap, Estimate, Resamples};
pub use distribution::Distribution;
pub use dominant::{SpectrumPeaks, spectrum_peaks};
pub use error::{Defect, Error, MAX_MAGNITUDE, Shape, Side};
pub use evaluation::{Evaluation, RejectedSample, ScoredSample};
pub use level::{LEVEL_FLOOR_DB, LevelDistance};
pub use metric::{Better, Metric};
pub use peaks::{Peak, PeakFinder, Topology};
pub use protocol::{
    AngleGrid, BinWidth, Definition, PeakScaling, Protocol, RecallCandidates, TOLERANCES_DEG,
};
pub use range::DataRange;
pub use report::{GroupReport, MapReport, MetricReport, PeakCensus, Report};
pub use sample::{SampleScores, Scorer};
pub use spectra::{Real, Spectra};

/// Threads can share what scores, and what comes out.
const _: fn() = || {
    fn is_shared<T: Clone + Send + Sync>() {}
    is_shared::<(Scorer, Evaluation, Resamples, Report, Error)>();
};
