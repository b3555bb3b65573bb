//! Angle power spectra and power delay profiles from propagation paths.
//!
//! A path arrives at a receiver with a delay, an angle and a power. Seen with a bandwidth f_s and an
//! array of N elements, a link's K paths blur into
//!
//! Q(tau, theta) = sum_k p_k sinc^2(f_s (tau - tau_k)) \[sin(N psi_k) / (N sin psi_k)\]^2,
//! psi_k = pi d_lambda (sin theta - sin theta_k),
//!
//! and the label is the angle power spectrum (APS) a(theta_j) = max over tau of Q(tau, theta_j) at
//! 180 azimuths, in dB. The power delay profile (PDP) is the same with the axes exchanged.
//!
//! - [`LabelConfig`] says what to compute, [`Protocol`] after which of two published definitions.
//! - [`Labeler`] holds the tables of a configuration; one serves all threads, each with its own
//!   [`Scratch`]. It turns [`PathSample`]s into a [`Label`].
//! - [`Normalization`] and [`Moments`] turn labels into learning targets.
//!
//! ```
//! use aps_label::{LabelConfig, Labeler, PathSample};
//!
//! let labeler = Labeler::new(&LabelConfig::paper())?;
//! let paths = [
//!     PathSample { delay_s: 310e-9, arrival_azimuth_rad: 0.40, gain_db: -82.0 },
//!     PathSample { delay_s: 455e-9, arrival_azimuth_rad: -1.1, gain_db: -97.5 },
//! ];
//! let label = labeler.label(&paths)?.expect("a link with paths has a label");
//! assert_eq!(label.aps_db.len(), 180);
//! let peak_db = label.aps_db.iter().copied().fold(f64::MIN, f64::max);
//! // The strongest path comes from between two bins, 0.9 degrees from the nearer one.
//! assert!((peak_db + 82.0).abs() < 0.25);
//! // A link without paths has no label. It is not a label of zeros.
//! assert!(labeler.label(&[])?.is_none());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The released maximum is taken on a coarse grid
//!
//! [`Protocol::Released`] reproduces the published data: the maximum over tau is taken at 128
//! delays 7.87 ns apart, while the pulse's null spacing at 200 MHz is 5 ns. A path that falls between
//! two of these delays loses 3.5 dB on average and up to 12 dB, a metre more or less moves it by
//! several dB, and a path beyond 1000 ns (300 m) all but vanishes. [`Protocol::Paper`] takes the
//! maximum over all delays and suffers from none of this. To see the difference, plot both labels of
//! one path against its delay.
//!
//! # How it is computed
//!
//! Q over a grid is a product of two thin matrices, pulse (tau x K) and power times array response
//! (K x theta), so its tau x theta x K terms cost one multiplication and one addition each, and
//! only its factors cost more. Then:
//!
//! - **Rows that cannot win are left out, and the result stays the same to the bit.** A delay whose
//!   pulse values are below a mixture of other delays' can be the maximum for no angle. With 20 paths
//!   that leaves some 17 of 128 delays.
//! - **The continuous maximum is certified.** Q is band-limited, so one sample in a cell of a third of a
//!   pulse bounds Q there, whatever the paths, and a polynomial of eight nodes stands for it. Few cells
//!   remain for each angle; Halley's method finds the tops of their polynomials, and a bound excludes the
//!   rest. The label is the polynomial's top, at most 2.25e-7, 9.8e-7 dB, from Q's maximum in that bin, and
//!   usually 1e-8; where delays are so long against the pulse (1e9 pulses and more) that doubles do not
//!   resolve its top so finely, by what the spacing of doubles allows.
//! - **The same bytes everywhere.** Paths are put in a canonical order, strongest first and scaled
//!   to power 1; every sum runs in a fixed order; no operation is fused; elementary functions are
//!   our own or `libm`'s, not the system's. Vector units are used as the running CPU has them and
//!   change no bit, nor does the number of threads or the order of the paths given.
//!
//! # Features
//!
//! - `serde` (off by default): `Serialize` and `Deserialize` for configurations, axes, paths and statistics.
//!
//! # Accuracy
//!
//! Q is a sum of squares, p_k r_k^2 with r_k the root of pulse times response. A root is off by at
//! most 2e-14 for the benchmark's array and delays, so Q is off by a relative 1e-13 where some r_k is
//! large, and by (2e-14)^2 times the link's power where all of them vanish. An input in f64 does not
//! determine these zeros more closely. A continuous maximum is off by its certified error besides. No
//! finite input gives NaN.
#![forbid(unsafe_code)]

mod array;
mod axis;
mod config;
mod continuous;
mod cover;
mod error;
mod label;
mod limits;
mod moments;
mod normalize;
mod paths;
mod polynomial;
mod product;
mod protocol;
mod pulse;
mod response;
mod select;
mod trig;

pub use array::{Array, ArrayForm};
pub use axis::Axis;
pub use config::{DelayAxis, LabelConfig};
pub use error::{ConfigError, NormalizationError, PathError};
pub use label::{Label, Labeler, Scratch, Status};
pub use limits::{MAX_DELAY_S, MAX_PATHS, NEGLIGIBLE_DB};
pub use moments::{MeanStd, Moments};
pub use normalize::{Normalization, SAMPLE_EPSILON, relative_power};
pub use paths::{HEADINGS_DEG, PathSample};
pub use protocol::{ParseProtocolError, Protocol};

/// Number of angle bins of an APS, in both protocols.
pub const ANGLE_BINS: usize = 180;

/// Threads can share what labels, and what comes out.
const _: fn() = || {
    fn is_shared<T: std::fmt::Debug + Clone + Send + Sync + 'static>() {}
    is_shared::<(LabelConfig, DelayAxis, Array, ArrayForm, Axis, Protocol)>();
    is_shared::<(Labeler, Scratch, Label, Status, PathSample)>();
    is_shared::<(Normalization, Moments, MeanStd, ConfigError, PathError)>();
    is_shared::<(NormalizationError, ParseProtocolError)>();
};
