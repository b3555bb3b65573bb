//! `cargo xtask`: builds and starts the runner, and starts the checks without it, whose build takes minutes.

use std::env;
use std::ffi::OsString;
use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    let mut args: Vec<OsString> = env::args_os().skip(1).collect();
    let mut program = if args.first().is_some_and(|command| command == "ci") {
        args[0] = concat!(env!("CARGO_MANIFEST_DIR"), "/../../.ci/run").into();
        Command::new("bash")
    } else {
        let mut cargo = Command::new(env::var_os("CARGO").unwrap_or("cargo".into()));
        cargo.args(["run", "--quiet", "--release", "--package", "xtask", "--"]);
        cargo
    };
    start(program.args(args))
}

/// Becomes the program, so that Ctrl-C meets only the one that does the work.
#[cfg(unix)]
fn start(program: &mut Command) -> ExitCode {
    use std::os::unix::process::CommandExt;
    let error = program.exec();
    failed(program, &error)
}

/// Waits for the program and passes its exit code on.
#[cfg(not(unix))]
fn start(program: &mut Command) -> ExitCode {
    match program.status() {
        Ok(status) => status
            .code()
            .map_or(ExitCode::FAILURE, |code| ExitCode::from(code as u8)),
        Err(error) => failed(program, &error),
    }
}

fn failed(program: &Command, error: &std::io::Error) -> ExitCode {
    eprintln!(
        "error: cannot start {}: {error}",
        program.get_program().display()
    );
    ExitCode::FAILURE
}
