//! Commands of other packages: built and started as a child, so that the others need not wait for its build.

use std::ffi::OsString;

use anyhow::{Context, Result};
use xtask_launch::{child, hand_over, package_of};

/// Handed on to the child as they are.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Arguments of the command; try --help.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    rest: Vec<OsString>,
}

impl Args {
    /// Runs `command` of another package; its failure, which it has told, is this process's too.
    pub fn run(self, command: &str) -> Result<()> {
        let args: Vec<OsString> = [command.into()].into_iter().chain(self.rest).collect();
        hand_over(child(package_of(command), &args)).context("cannot start cargo")
    }
}
