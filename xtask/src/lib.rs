//! The runner behind `cargo xtask`: its command line, and what its commands share.
//!
//! A library, so that the commands that need models (package `xtask-models`) draw the same pictures and read the same
//! maps, while those that need none are built without them.

// Both panic when the reader has gone away: see [`output`].
#![warn(clippy::print_stdout, clippy::print_stderr)]
// Brackets in the comments of arguments are units in the help that clap makes of them.
#![allow(rustdoc::broken_intra_doc_links)]

mod args;
pub mod benchmark;
mod cautions;
pub mod chart;
pub mod cli;
mod command_line;
mod commands;
pub mod drawing;
pub mod interrupt;
mod lobes;
pub mod machine;
mod maps;
pub mod output;
pub mod page;
mod picture;
mod plan;
mod produce;
mod production;
mod progress;
mod samples;
mod sampling;
mod settings;
mod source;
mod spectra;
pub mod studies;
mod summary;
pub mod targets;
pub mod theme;
mod tiles;
mod view;
mod whole_files;
mod wire;

pub use maps::{IdList, MapSource, SceneSettings};
pub use plan::{DatasetPlan, MapTime};
pub use progress::use_threads;
pub use sampling::Receivers;
pub use settings::Stored;
