//! A benchmark, as it is asked for.

use std::path::PathBuf;

use aps_report::benchmark::Machine;

use crate::config::Config;
use crate::error::Result;

/// A benchmark with its folder.
#[derive(Debug, Clone)]
pub struct Benchmark {
    pub(crate) config: Config,
    pub(crate) out: PathBuf,
    /// If true, everything is made anew; false by default.
    pub fresh: bool,
    /// Name of the settings in the report; `custom` by default.
    pub profile: String,
    /// Machine and build in the report, which this crate does not find out; empty by default.
    pub machine: Machine,
}

impl Benchmark {
    /// Makes a benchmark whose parts lie in the folder `out`; those of an earlier one with the same settings are used again.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn new(config: Config, out: impl Into<PathBuf>) -> Result<Self> {
        config.check()?;
        Ok(Self {
            config,
            out: out.into(),
            fresh: false,
            profile: "custom".into(),
            machine: Machine::default(),
        })
    }
}
