//! Commands that need candle: built and started as a child, so that the others need not wait for its build.

use std::ffi::OsString;
use std::process::{Command, exit};

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
        cargo.arg("--").arg(command).args(&self.rest);
        let status = cargo.status().context("cannot start cargo")?;
        match status.code() {
            Some(0) => Ok(()),
            code => exit(code.unwrap_or(1)),
        }
    }

    /// The feature of candle that the device named in `--device` needs.
    fn device_feature(&self) -> Option<&'static str> {
        let named = |i: usize, name: &str| {
            let after = self.rest.get(i + 1).is_some_and(|value| value == name);
            self.rest[i] == *format!("--device={name}") || (self.rest[i] == "--device" && after)
        };
        ["cuda", "metal"]
            .into_iter()
            .find(|name| (0..self.rest.len()).any(|i| named(i, name)))
    }
}
