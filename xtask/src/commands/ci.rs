//! `cargo xtask ci`: the checks that every change must pass.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

/// Run the checks that every change must pass: `.ci/run`, which lists them.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Only these, of format, lint, doc, test, alone, features, downstream, package.
    steps: Vec<String>,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let script = repository().join(".ci/run");
        let status = Command::new("bash").arg(&script).args(&self.steps).status();
        let status = status.with_context(|| format!("cannot run '{}'", script.display()))?;
        ensure!(status.success(), "'{}' failed: {status}", script.display());
        Ok(())
    }
}

/// Where the sources are: cargo tells, and else it is where this was built.
fn repository() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let package = package.unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    package.parent().unwrap_or(Path::new(".")).into()
}
