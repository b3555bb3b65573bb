//! The amount of measurement.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// The amount of measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// Seconds: everything once, to see that it works. Its times mean nothing.
    Smoke,
    /// Minutes: what a report is made of.
    Full,
}

impl Profile {
    /// Name on the command line.
    pub fn name(self) -> String {
        name_of(&self)
    }

    /// The value for this profile.
    pub fn choose<T>(self, smoke: T, full: T) -> T {
        match self {
            Self::Smoke => smoke,
            Self::Full => full,
        }
    }
}

/// The name of a value on the command line.
pub fn name_of(value: &impl ValueEnum) -> String {
    let shown = value.to_possible_value().expect("no value is hidden");
    shown.get_name().into()
}
