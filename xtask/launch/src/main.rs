//! `cargo xtask`: builds and starts the program that has the command, and starts the checks without any, whose build takes minutes.

use std::env;
use std::ffi::OsString;
use std::process::{Command, ExitCode};

use xtask_launch::{child, hand_over, package_of};

fn main() -> ExitCode {
    let args: Vec<OsString> = env::args_os().skip(1).collect();
    let command = args.first().and_then(|command| command.to_str());
    let program = match command.unwrap_or_default() {
        "ci" => {
            let mut bash = Command::new("bash");
            bash.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../../.ci/run"));
            bash.args(&args[1..]);
            bash
        }
        command => child(package_of(command), &args),
    };
    let name = program.get_program().to_owned();
    match hand_over(program) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: cannot start {}: {error}", name.display());
            ExitCode::FAILURE
        }
    }
}
