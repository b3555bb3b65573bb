//! The commands of `cargo xtask` that need models. The runner builds and starts this program when one is asked for.

// Both panic when the reader has gone away: see `xtask::output`.
#![warn(clippy::print_stdout, clippy::print_stderr)]
// Brackets in the comments of arguments are units in the help that clap makes of them.
#![allow(rustdoc::broken_intra_doc_links)]

mod bench;
mod choices;
mod export_onnx;
mod predict;
mod run;
mod study;
mod train;
mod watch;
mod weights;

use std::process::ExitCode;

use clap::Parser;

/// Training asks for the same tensors every step: memory is used again rather than taken page by page from the system,
/// which costs a tenth of a step with the system's allocator.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Models of angle power spectra.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
enum Cli {
    /// Train a model on a data set.
    Train(train::Args),
    /// Predict spectra with a trained model.
    Predict(predict::Args),
    /// Write a trained model as a file of ONNX.
    ExportOnnx(export_onnx::Args),
    /// Train, score and time models against each other, baselines and the tracer, and report.
    BenchModels(bench::Args),
    /// Measure what precision, batches and image size cost: the study of models of the numerical report.
    Report(study::Args),
}

fn main() -> ExitCode {
    xtask::cli::exit_code(match Cli::parse() {
        Cli::Train(args) => args.run(),
        Cli::Predict(args) => args.run(),
        Cli::ExportOnnx(args) => args.run(),
        Cli::BenchModels(args) => args.run(),
        Cli::Report(args) => args.run(),
    })
}
