//! Models trained for the same time on the same links, scored and timed against each other, baselines and the tracer.
//!
//! A [`Config`] holds all settings. A [`Profile`] is a built-in configuration, and [`Config::resolve`] changes single settings of
//! it. [`Benchmark::run`] makes the data set, trains every model, has all of them and the baselines predict the test links, and
//! returns the [`Results`](aps_report::benchmark::Results) that a report is made of:
//!
//! ```ignore
#![doc = include_str!("../examples/tiny_benchmark.rs")]
//! ```
//!
//! # Files
//!
//! - `configuration.json`: every setting, and the mark of a benchmark's folder; in no other is anything ever removed;
//! - `data`, `models`, `scores`: the data set, weights, predictions and scores of single links. Each of these parts has a stamp with its
//!   settings. A part that was finished with the same settings is used again, a training that was begun is continued, and all else is made anew;
//! - `results.json`, `report.html`, `report.md` with `tables` and `figures`.
//!
//! # While it runs
//!
//! Nothing is printed. A [`Watch`] names an [`Observer`], who is told what happens, and a flag that ends the work; all that is
//! finished by then is kept, and the next run goes on from there. What fails is an entry of
//! [`Results::failed`](aps_report::benchmark::Results::failed), and the others go on.
#![forbid(unsafe_code)]

mod answer;
mod baselines;
mod benchmark;
mod config;
mod data;
mod entry;
mod error;
mod examples;
mod files;
mod job;
mod latency;
mod model;
mod part;
mod run;
mod summary;
mod test_bed;
mod test_set;
mod tracer;
mod tune;
mod watch;

pub use benchmark::Benchmark;
pub use config::{
    Config, DataConfig, LatencyConfig, ModelConfig, Pretrained, Profile, TracerConfig,
    TrainingConfig,
};
pub use error::{Error, Result};
pub use test_bed::{Measured, TestBed};
pub use tune::{Outcome, Trial};
pub use watch::{Event, Observer, Watch};
