//! The command `report` of `cargo xtask`. The runner builds and starts this program when it is asked for.

use std::process::ExitCode;

use clap::Parser;
use xtask_studies::command;

/// Studies of error against run time.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
enum Cli {
    /// Measure error against run time, and report it.
    Report(command::Args),
}

fn main() -> ExitCode {
    let Cli::Report(args) = Cli::parse();
    xtask::cli::exit_code(args.run())
}
