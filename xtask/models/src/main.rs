//! The commands of `cargo xtask` that need models. The runner builds and starts this program when one is asked for.

// Brackets in the comments of arguments are units in the help that clap makes of them.
#![allow(rustdoc::broken_intra_doc_links)]

mod data;
mod device;
mod journal;
mod labels;
mod network;
mod predict;
mod run;
mod score;
mod settings;
mod train;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Models of angle power spectra.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Train a model on a data set.
    Train(train::Args),
    /// Predict spectra with a trained model.
    Predict(predict::Args),
}

fn main() -> ExitCode {
    xtask::cli::exit_code(match Cli::parse().command {
        Command::Train(args) => args.run(),
        Command::Predict(args) => args.run(),
    })
}
