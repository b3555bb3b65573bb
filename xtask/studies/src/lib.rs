//! Numerical studies: the cost of settings in time and in error, measured on the machine at hand.
//!
//! A [`Study`] is a section of a document, tables, figures and verdicts, with its data as CSV. It is written into a folder
//! as `NAME.json` beside its `NAME-*.csv` and `NAME-*.svg`; [`join`] makes one document of all studies it finds there,
//! whoever wrote them. So one study can be measured anew without the others, and another program can add its own:
//!
//! ```
//! use aps_report::chart::{Axis, Chart};
//! use xtask_studies::{Conditions, Profile, Study, join};
//!
//! let folder = tempfile::tempdir()?;
//! let mut study = Study::new("halves", "Halving");
//! let chart = Chart::new(Axis::log("time [ns]"), Axis::log("error"))
//!     .line("halving", [[1.0, 0.5], [2.0, 0.25]]);
//! study.figure("error-time", "Error against time.", chart.draw());
//! let conditions = Conditions::now(Profile::Smoke, 42, "cargo xtask report");
//! study.write(folder.path(), conditions)?;
//! let document = join(folder.path(), "numerics")?;
//! assert!(document.contains("![Error against time.](numerics/halves-error-time.svg)"));
//! # Ok::<(), anyhow::Error>(())
//! ```
//!
//! Times are taken on one thread, after a warm-up, as medians of repeats ([`Stopwatch`]). Errors are taken against
//! references that the crates under study have no part in, or, where that cannot be (the tracer), against their own most
//! costly setting.

// Both panic when the reader has gone away: see `xtask::output`.
#![warn(clippy::print_stdout, clippy::print_stderr)]
// Brackets in the comments of arguments are units in the help that clap makes of them.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod command;
mod conditions;
mod diffraction;
mod errors;
mod fullwave;
mod join;
mod label;
mod links;
mod pruning;
mod rounding;
mod scenes;
mod stopwatch;
mod study;
mod tracer;

use anyhow::Result;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

pub use conditions::Conditions;
pub use join::{join, publish, studies_folder};
pub use scenes::{MapChoice, NamedScene};
pub use stopwatch::{Stopwatch, on_one_thread};
pub use study::{Column, FORMAT, Study};

/// The amount of measurement.
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
    pub fn name(self) -> String {
        name(&self)
    }

    /// The value for this profile.
    pub fn choose<T>(self, smoke: T, full: T) -> T {
        match self {
            Self::Smoke => smoke,
            Self::Full => full,
        }
    }
}

/// The name of a value on the command line.
fn name(value: &impl ValueEnum) -> String {
    let shown = value.to_possible_value().expect("no value is hidden");
    shown.get_name().into()
}

/// The studies, in the order in which they run and, but for that of models, stand in the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum StudyName {
    /// Limits of the tracer: label error against time a link.
    Tracer,
    /// Delay axis of the label: error against time a label.
    Label,
    /// The diffraction coefficient against exact solutions.
    Diffraction,
    /// The tracer against the solution of the wave equation in small scenes.
    Fullwave,
    /// Savings by leaving out, and their costs.
    Pruning,
    /// Worst errors of the kernels in ulps.
    Rounding,
    /// Precision, batch and image size of models: error against time an answer.
    Models,
}

/// Settings of all studies.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Amount of measurement.
    pub profile: Profile,
    /// Seed of terminals, synthetic cities and drawn numbers.
    pub seed: u64,
    /// The maps of the study of the tracer.
    pub maps: MapChoice,
}

impl StudyName {
    /// As the command line and the files have it.
    pub fn name(self) -> String {
        name(&self)
    }

    /// The study without anything in it, in the place of its name.
    fn study(self, title: &str) -> Study {
        Study::new(&self.name(), title).at(1 + self as u32)
    }

    /// Measures. A bar tells how far it is. The study of models is another program's, which links candle: none comes back.
    ///
    /// # Errors
    /// Maps that cannot be read or hold too few outdoor points.
    pub fn run(self, setup: &Setup) -> Result<Option<Study>> {
        let study = match self {
            Self::Tracer => tracer::run(setup),
            Self::Label => label::run(setup),
            Self::Diffraction => diffraction::run(setup),
            Self::Fullwave => fullwave::run(setup),
            Self::Pruning => pruning::run(setup),
            Self::Rounding => rounding::run(),
            Self::Models => return Ok(None),
        };
        study.map(Some)
    }
}
