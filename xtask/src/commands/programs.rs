//! Commands of other packages: built and started as a child, so that the others need not wait for its build.

use std::env;
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
    /// Runs `command` of a package; its failure, which it has told, is this process's too.
    pub fn run(self, package: &str, command: &str) -> Result<()> {
        hand_over(child(package, command, &self.rest))
    }
}

/// The delay after which the child's allocator gives free memory back to the system \[ms\]. Never is best: a step of training asks for the
/// same memory as the last one, and pages that come back cleared cost a tenth of it.
const PURGE: &str = "MIMALLOC_PURGE_DELAY";

/// The process that does `command` of a package with `rest`, built first where it is not yet.
pub fn child(package: &str, command: &str, rest: &[OsString]) -> Command {
    let mut cargo = Command::new(env::var_os("CARGO").unwrap_or("cargo".into()));
    cargo.args(["run", "--release", "--package", package]);
    // The first build takes minutes, and cargo shows how far it is.
    if was_built(package) {
        cargo.arg("--quiet");
    }
    if let Some(device) = device_feature(rest) {
        cargo.args(["--features", device]);
    }
    if let Some(threads) = value_of(rest, "--threads") {
        // candle counts its threads by this variable alone.
        cargo.env("RAYON_NUM_THREADS", threads);
    }
    if env::var_os(PURGE).is_none() {
        cargo.env(PURGE, "-1");
    }
    cargo.arg("--").arg(command).args(rest);
    cargo
}

/// Tells if the child's program is there, if perhaps of an earlier version.
fn was_built(package: &str) -> bool {
    let name = format!("{package}{}", env::consts::EXE_SUFFIX);
    env::current_exe().is_ok_and(|own| own.with_file_name(name).is_file())
}

/// The feature of candle that the device named in `--device` needs.
fn device_feature(rest: &[OsString]) -> Option<&'static str> {
    let device = value_of(rest, "--device")?;
    ["cuda", "metal"].into_iter().find(|&name| device == name)
}

/// The value given to an option as `NAME VALUE` or `NAME=VALUE`.
fn value_of<'a>(rest: &'a [OsString], name: &str) -> Option<&'a str> {
    let rest: Vec<&str> = rest.iter().filter_map(|arg| arg.to_str()).collect();
    (0..rest.len()).find_map(|i| match rest[i].strip_prefix(name)? {
        "" => rest.get(i + 1).copied(),
        given => given.strip_prefix('='),
    })
}

/// Becomes the command, so that Ctrl-C meets only the one that does the work.
///
/// # Errors
/// The command cannot be started. Otherwise this does not return.
#[cfg(unix)]
pub fn hand_over(mut command: Command) -> Result<()> {
    use std::os::unix::process::CommandExt;
    Err(command.exec()).context("cannot start cargo")
}

/// Waits for the command and ends with its exit code.
///
/// # Errors
/// The command cannot be started.
#[cfg(not(unix))]
pub fn hand_over(mut command: Command) -> Result<()> {
    let status = command.status().context("cannot start cargo")?;
    match status.code() {
        Some(0) => Ok(()),
        code => std::process::exit(code.unwrap_or(1)),
    }
}
