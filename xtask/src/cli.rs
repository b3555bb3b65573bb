//! The command line: one variant a command.

use std::process::ExitCode;

use clap::Parser;

use crate::advice::advice;
use crate::commands;
use crate::interrupt;
use crate::note;
use crate::output;

/// City maps to ray-traced paths to angle power spectra.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
#[command(after_help = "Checks that every change must pass: cargo xtask ci")]
enum Cli {
    /// Make a labelled data set from maps.
    Dataset(commands::dataset::Args),
    /// Make a data set on a Slurm cluster.
    Slurm(commands::slurm::Args),
    /// Tell what a data set holds, and what an unfinished one lacks.
    Info(commands::info::Args),
    /// Check a data set, also against the maps it was made of.
    Verify(commands::verify::Args),
    /// Label the stored paths of a data set anew.
    Relabel(commands::relabel::Args),
    /// Trace single links and print or draw their paths.
    Trace(commands::trace::Args),
    /// Show which path makes which lobe of a spectrum.
    Explain(commands::explain::Args),
    /// Show a data set on one page: links to look at, and statistics.
    Gallery(commands::gallery::Args),
    /// Make labels for path lists from anywhere.
    Label(commands::label::Args),
    /// Score predictions of any model against labels.
    Metrics(commands::metrics::Args),
    /// Write a data set as the files of the published data.
    Export(commands::export::Args),
    /// Make a data set of the published data's files.
    Import(commands::import::Args),
    /// Look at links live in a browser: drag a terminal through the city, and paths and spectrum follow.
    #[command(disable_help_flag = true)]
    Explore(commands::programs::Args),
    /// Measure error against run time, and report it.
    #[command(disable_help_flag = true)]
    Report(commands::programs::Args),
    /// Train a model on a data set.
    #[command(disable_help_flag = true)]
    Train(commands::programs::Args),
    /// Predict spectra with a trained model.
    #[command(disable_help_flag = true)]
    Predict(commands::programs::Args),
    /// Write a trained model as a file of ONNX.
    #[command(disable_help_flag = true)]
    ExportOnnx(commands::programs::Args),
    /// Train, score and time models against each other, baselines and the tracer, and report.
    #[command(disable_help_flag = true)]
    BenchModels(commands::programs::Args),
}

/// Runs the command line of this process.
pub fn run() -> ExitCode {
    let result = match Cli::parse() {
        Cli::Dataset(args) => args.run(),
        Cli::Slurm(args) => args.run(),
        Cli::Info(args) => args.run(),
        Cli::Verify(args) => args.run(),
        Cli::Relabel(args) => args.run(),
        Cli::Trace(args) => args.run(),
        Cli::Explain(args) => args.run(),
        Cli::Gallery(args) => args.run(),
        Cli::Label(args) => args.run(),
        Cli::Metrics(args) => args.run(),
        Cli::Export(args) => args.run(),
        Cli::Import(args) => args.run(),
        Cli::Explore(args) => args.run("explore"),
        Cli::Report(args) => args.run("report"),
        Cli::Train(args) => args.run("train"),
        Cli::Predict(args) => args.run("predict"),
        Cli::ExportOnnx(args) => args.run("export-onnx"),
        Cli::BenchModels(args) => args.run("bench-models"),
    };
    exit_code(result)
}

/// Prints the error, if any, in one line. After Ctrl-C the status is 130.
pub fn exit_code(result: anyhow::Result<()>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            note!("error: {}{}", output::told(error.as_ref()), advice(&error));
            match interrupt::was_interrupted() {
                true => ExitCode::from(interrupt::STATUS),
                false => ExitCode::FAILURE,
            }
        }
    }
}
