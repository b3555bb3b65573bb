//! The command `explore` of `cargo xtask`. The runner builds and starts this program when it is asked for.

// Brackets in the comments of arguments are units in the help that clap makes of them.
#![allow(rustdoc::broken_intra_doc_links)]
// Both panic when the reader has gone away: see `xtask::output`.
#![warn(clippy::print_stdout, clippy::print_stderr)]

mod command;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Links live in a browser.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Look at links live in a browser: drag a terminal through the city, and paths and spectrum follow.
    Explore(command::Args),
}

fn main() -> ExitCode {
    let Command::Explore(args) = Cli::parse().command;
    xtask::cli::exit_code(args.run())
}
