//! Programs of the runner, each a package that is built when one of its commands is first asked for.

use std::env;
use std::ffi::OsString;
use std::io;
use std::process::Command;

/// Commands that are not of package `xtask`, and the packages that have them.
const ELSEWHERE: [(&str, &str); 6] = [
    ("explore", "xtask-explore"),
    ("report", "xtask-studies"),
    ("train", "xtask-models"),
    ("predict", "xtask-models"),
    ("export-onnx", "xtask-models"),
    ("bench-models", "xtask-models"),
];

/// The delay after which the child's allocator gives free memory back to the system \[ms\]. Never is best: a step of training asks for the
/// same memory as the last one, and pages that come back cleared cost a tenth of it.
const PURGE: &str = "MIMALLOC_PURGE_DELAY";

/// The package that has a command.
pub fn package_of(command: &str) -> &'static str {
    let known = ELSEWHERE.iter().find(|(name, _)| *name == command);
    known.map_or("xtask", |(_, package)| package)
}

/// The process that runs a package's program with `args`, the command first; cargo builds it where it is not yet.
pub fn child(package: &str, args: &[OsString]) -> Command {
    let mut cargo = Command::new(env::var_os("CARGO").unwrap_or("cargo".into()));
    cargo.args(["run", "--release", "--package", package]);
    // The first build takes minutes, and cargo shows how far it is.
    if was_built(package) {
        cargo.arg("--quiet");
    }
    if let Some(device) = device_feature(args) {
        cargo.args(["--features", device]);
    }
    if let Some(threads) = value_of(args, "--threads") {
        // candle counts its threads by this variable alone.
        cargo.env("RAYON_NUM_THREADS", threads);
    }
    if env::var_os(PURGE).is_none() {
        cargo.env(PURGE, "-1");
    }
    cargo.arg("--").args(args);
    cargo
}

/// Tells if the package's program is there, if perhaps of an earlier version. This one lies in the folder of its profile beside that of
/// the releases.
fn was_built(package: &str) -> bool {
    let name = format!("release/{package}{}", env::consts::EXE_SUFFIX);
    let own = env::current_exe().unwrap_or_default();
    let target = own.ancestors().nth(2);
    target.is_some_and(|target| target.join(name).is_file())
}

/// The feature of candle that the device named in `--device` needs.
fn device_feature(args: &[OsString]) -> Option<&'static str> {
    let device = value_of(args, "--device")?;
    ["cuda", "metal"].into_iter().find(|&name| device == name)
}

/// The value given to an option as `NAME VALUE` or `NAME=VALUE`.
fn value_of<'a>(args: &'a [OsString], name: &str) -> Option<&'a str> {
    let args: Vec<&str> = args.iter().filter_map(|arg| arg.to_str()).collect();
    (0..args.len()).find_map(|i| match args[i].strip_prefix(name)? {
        "" => args.get(i + 1).copied(),
        given => given.strip_prefix('='),
    })
}

/// Becomes the command, so that Ctrl-C meets only the one that does the work.
///
/// # Errors
/// The command cannot be started. Otherwise this does not return.
#[cfg(unix)]
pub fn hand_over(mut command: Command) -> io::Result<()> {
    use std::os::unix::process::CommandExt;
    Err(command.exec())
}

/// Waits for the command and ends with its exit code.
///
/// # Errors
/// The command cannot be started.
#[cfg(not(unix))]
pub fn hand_over(mut command: Command) -> io::Result<()> {
    match command.status()?.code() {
        Some(0) => Ok(()),
        code => std::process::exit(code.unwrap_or(1)),
    }
}
