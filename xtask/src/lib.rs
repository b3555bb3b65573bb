//! The runner behind `cargo xtask`: its command line and what it prints. The work is done by `map2aps`.
//!
//! A library, so that the programs that are built only when they are asked for (packages `xtask-models`,
//! `xtask-studies` and `xtask-explore`) print and read arguments alike.

// Both panic when the reader has gone away: see [`output`].
#![warn(clippy::print_stdout, clippy::print_stderr)]
// Brackets in the comments of arguments are units in the help that clap makes of them.
#![allow(rustdoc::broken_intra_doc_links)]

mod advice;
mod args;
mod cautions;
pub mod cli;
pub mod command_line;
mod commands;
pub mod interrupt;
pub mod machine;
pub mod output;
pub mod progress;
mod source;
mod summary;

pub use args::{IdList, SceneArgs, TileArgs, limits, named, parts};
pub use progress::use_threads;
