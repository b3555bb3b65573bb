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
mod profile;
mod pruning;
mod rounding;
mod scenes;
mod setup;
mod stopwatch;
mod study;
mod tracer;

pub use conditions::Conditions;
pub use join::{join, publish, studies_folder};
pub use profile::Profile;
pub use scenes::{MapChoice, NamedScene};
pub use setup::{Setup, StudyName};
pub use stopwatch::{Stopwatch, on_one_thread};
pub use study::{Column, FORMAT, Study};
