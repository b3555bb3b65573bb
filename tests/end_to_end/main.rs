//! The runner as a user meets it: its commands on real arguments, its files, its errors.

mod city;
mod command;
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

use command::{assert_told, fail, remarks, run as xtask, succeed};

/// The runner.
const PROGRAM: &str = env!("CARGO_BIN_EXE_xtask");
