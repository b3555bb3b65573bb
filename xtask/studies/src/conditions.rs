//! Conditions of a study: machine, version, settings.

use std::time::Instant;

use aps_report::benchmark::Machine;
use serde::{Deserialize, Serialize};
use xtask::machine;

use crate::profile::Profile;

/// Conditions of a study.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Conditions {
    /// Amount of measurement.
    pub profile: Profile,
    /// Seed of all that was drawn.
    pub seed: u64,
    /// The command that does it again, without folders.
    pub command: String,
    /// Machine, time and version.
    pub machine: Machine,
    /// Its beginning; ends [`Machine::seconds_total`].
    #[serde(skip)]
    began: Option<Instant>,
}

impl Conditions {
    /// The conditions of a study that begins now.
    pub fn now(profile: Profile, seed: u64, command: impl Into<String>) -> Self {
        Self {
            profile,
            seed,
            command: command.into(),
            machine: machine::describe(),
            began: Some(Instant::now()),
        }
    }

    /// Ends the study now.
    #[must_use]
    pub fn ended(mut self) -> Self {
        if let Some(began) = self.began.take() {
            self.machine.seconds_total = began.elapsed().as_secs_f64();
        }
        self
    }
}
