//! The runner behind `cargo xtask`: its command line, and the code that its commands share.
//!
//! A library, so that the programs that are built only when they are asked for (packages `xtask-models` and
//! `xtask-studies`) read the same maps.

// Both panic when the reader has gone away: see [`output`].
#![warn(clippy::print_stdout, clippy::print_stderr)]
// Brackets in the comments of arguments are units in the help that clap makes of them.
#![allow(rustdoc::broken_intra_doc_links)]

mod args;
mod cautions;
pub mod cli;
pub mod command_line;
mod commands;
pub mod interrupt;
pub mod machine;
mod maps;
pub mod output;
mod plan;
mod produce;
mod production;
pub mod progress;
mod samples;
mod sampling;
mod settings;
mod source;
mod summary;
pub mod targets;
mod tiles;
mod wire;

pub use commands::programs::{child, hand_over};
pub use maps::{IdList, MapSource, SceneSettings, choose as choose_maps, ranges as map_ranges};
pub use plan::{DatasetPlan, MapTime};
pub use progress::use_threads;
pub use sampling::{Receivers, draw as draw_terminals};
