//! Commands that need candle: built and started as a child, so that the others need not wait for its build.

use std::ffi::OsString;
use std::process::Command;

use anyhow::{Context, Result};

/// Handed on to the child as they are.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Arguments of the command; try --help.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    rest: Vec<OsString>,
}

impl Args {
    /// Runs `command` of the package `xtask-models`; its failure, which it has told, is this process's too.
    pub fn run(self, command: &str) -> Result<()> {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
        cargo.args(["run", "--quiet", "--release", "--package", "xtask-models"]);
        if let Some(device) = self.device_feature() {
            cargo.args(["--features", device]);
        }
        if let Some(threads) = self.value_of("--threads") {
            // candle counts its threads by this variable alone.
            cargo.env("RAYON_NUM_THREADS", threads);
        }
        cargo.arg("--").arg(command).args(&self.rest);
        hand_over(cargo)
    }

    /// The feature of candle that the device named in `--device` needs.
    fn device_feature(&self) -> Option<&'static str> {
        let device = self.value_of("--device")?;
        ["cuda", "metal"].into_iter().find(|&name| device == name)
    }

    /// The value given to an option as `NAME VALUE` or `NAME=VALUE`.
    fn value_of(&self, name: &str) -> Option<&str> {
        let rest: Vec<&str> = self.rest.iter().filter_map(|arg| arg.to_str()).collect();
        (0..rest.len()).find_map(|i| match rest[i].strip_prefix(name)? {
            "" => rest.get(i + 1).copied(),
            given => given.strip_prefix('='),
        })
    }
}

/// Becomes the command, so that Ctrl-C meets only the one that does the work.
#[cfg(unix)]
fn hand_over(mut command: Command) -> Result<()> {
    use std::os::unix::process::CommandExt;
    Err(command.exec()).context("cannot start cargo")
}

/// Waits for the command and ends with its exit code.
#[cfg(not(unix))]
fn hand_over(mut command: Command) -> Result<()> {
    let status = command.status().context("cannot start cargo")?;
    match status.code() {
        Some(0) => Ok(()),
        code => std::process::exit(code.unwrap_or(1)),
    }
}
