//! The commands, one file each.

pub mod dataset;
pub mod export;
pub mod import;
pub mod explain;
pub mod gallery;
pub mod label;
pub mod metrics;
pub mod models;
pub mod trace;
