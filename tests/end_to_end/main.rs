//! The runner as a user meets it: its commands on real arguments, its files, its errors.

mod city;
mod dataset;
mod exchange;
mod faults;
mod folder;
mod foreign_city;
mod info;
mod label;
mod metrics;
mod one_city;
mod pages;
#[cfg(unix)]
mod pipes;
#[cfg(unix)]
mod programs;
mod receivers;
mod relabel;
mod shards;
#[cfg(unix)]
mod slurm;
mod trace;
mod verify;

use std::process::{Command, Output};

/// The runner with these arguments.
fn xtask(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(args)
        .output()
        .expect("the runner starts")
}

/// Standard output of a run that must succeed.
#[track_caller]
fn succeed(args: &[&str]) -> String {
    let output = xtask(args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    let stdout = String::from_utf8(output.stdout).expect("output is text");
    assert!(output.status.success(), "{args:?}: {stderr}{stdout}");
    stdout
}

/// Standard error of a run that must fail.
#[track_caller]
fn fail(args: &[&str]) -> String {
    let output = xtask(args);
    assert!(!output.status.success(), "{args:?} succeeded");
    String::from_utf8_lossy(&output.stderr).into_owned()
}
