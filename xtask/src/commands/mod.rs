//! The commands, one file each.

pub mod dataset;
pub mod explain;
pub mod export;
pub mod gallery;
pub mod import;
pub mod info;
pub mod label;
pub mod metrics;
pub mod programs;
pub mod relabel;
pub mod slurm;
pub mod trace;
pub mod verify;
