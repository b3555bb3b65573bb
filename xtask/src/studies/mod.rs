//! Numerical studies: what a setting costs in time and what in error, measured on the machine at hand.
//!
//! A [`Study`] is what one of them has to say: paragraphs, tables, figures, and its data as CSV. It is
//! written into a folder as `NAME.json` beside its `NAME-*.csv` and `NAME-*.svg`; [`join`] makes one
//! document of all studies it finds there, whoever wrote them. So one study can be measured anew
//! without the others, and another program can add its own:
//!
//! ```
//! use xtask::chart::{Axis, Chart};
//! use xtask::studies::{Conditions, Profile, Study, join};
//!
//! let folder = tempfile::tempdir()?;
//! let mut study = Study::new("halves", "Halving");
//! study.text("Each step halves the error, and takes twice as long.");
//! let chart = Chart::new(Axis::log("time [ns]"), Axis::log("error"))
//!     .line("halving", [[1.0, 0.5], [2.0, 0.25]]);
//! study.figure("error-time", "Error against time.", &chart.draw());
//! let conditions = Conditions::now(Profile::Smoke, 42, "cargo xtask report");
//! study.write(folder.path(), conditions)?;
//! let document = join(folder.path(), "numerics")?;
//! assert!(document.contains("![Error against time.](numerics/halves-error-time.svg)"));
//! # Ok::<(), anyhow::Error>(())
//! ```
//!
//! No figure in a paragraph is written by hand: sentences are made from what was measured, and say so
//! if it turns out otherwise. Times are taken on one thread, after a warm-up, as medians of repeats
//! ([`Stopwatch`]). Errors are taken against references that the crates under study have no part in,
//! or, where that cannot be (the tracer), against their own most costly setting.

mod conditions;
mod diffraction;
mod document;
mod errors;
mod label;
mod links;
mod pruning;
mod rounding;
mod scenes;
mod stopwatch;
mod study;
mod tracer;
mod trade;

use anyhow::Result;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

pub use conditions::Conditions;
pub use document::{join, publish, studies_folder};
pub use scenes::{MapChoice, NamedScene};
pub use stopwatch::{Stopwatch, Timing, on_one_thread};
pub use study::{Block, FORMAT, Study};
pub use trade::{Choice, Marked, Trade, small};

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// Seconds: everything once, to see that it works. Its times mean nothing.
    Smoke,
    /// Minutes: what a report is made of.
    Full,
}

impl Profile {
    /// As the command line has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Smoke => "smoke",
            Self::Full => "full",
        }
    }

    /// The value for this profile.
    pub fn choose<T>(self, smoke: T, full: T) -> T {
        match self {
            Self::Smoke => smoke,
            Self::Full => full,
        }
    }
}

/// The studies of this program, in the order of the document.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum StudyName {
    /// Limits of the tracer: label error against time a link.
    Tracer,
    /// Delay axis, precision and kernels of the label: error against time a label.
    Label,
    /// The diffraction coefficient against exact solutions.
    Diffraction,
    /// What leaving out saves, and what it costs.
    Pruning,
    /// Worst errors of the kernels in ulps.
    Rounding,
}

/// What all studies are given.
#[derive(Debug, Clone)]
pub struct Setup {
    /// How much to measure.
    pub profile: Profile,
    /// Seed of terminals, synthetic cities and drawn numbers.
    pub seed: u64,
    /// The maps of the study of the tracer.
    pub maps: MapChoice,
}

impl StudyName {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Tracer,
        Self::Label,
        Self::Diffraction,
        Self::Pruning,
        Self::Rounding,
    ];

    /// As the command line and the files have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tracer => "tracer",
            Self::Label => "label",
            Self::Diffraction => "diffraction",
            Self::Pruning => "pruning",
            Self::Rounding => "rounding",
        }
    }

    /// Measures. A bar tells how far it is.
    ///
    /// # Errors
    /// Maps that cannot be read or hold too few outdoor points.
    pub fn run(self, setup: &Setup) -> Result<Study> {
        match self {
            Self::Tracer => tracer::run(setup),
            Self::Label => label::run(setup),
            Self::Diffraction => diffraction::run(setup),
            Self::Pruning => pruning::run(setup),
            Self::Rounding => rounding::run(),
        }
    }
}
