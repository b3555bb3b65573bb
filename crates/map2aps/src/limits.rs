//! Limits of the paths in labels, by name.

use std::fmt;
use std::str::FromStr;

use aps_raytrace::TraceConfig;
use serde::{Deserialize, Serialize};

/// Limits of the paths that labels are made of.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Limits {
    /// 2 reflections, 1 diffraction, paths within 60 dB of the strongest ([`TraceConfig::default`]).
    R2d1,
    /// 5 reflections, 2 diffractions, paths within 20 dB ([`TraceConfig::converged`]): further reflections and weaker paths change labels
    /// by 1 dB in the mean.
    #[default]
    Converged,
}

impl Limits {
    /// Both, the default last.
    pub const ALL: [Self; 2] = [Self::R2d1, Self::Converged];

    /// `r2d1` or `converged`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::R2d1 => "r2d1",
            Self::Converged => "converged",
        }
    }

    /// The settings of the tracer.
    pub fn config(self) -> TraceConfig {
        match self {
            Self::R2d1 => TraceConfig::default(),
            Self::Converged => TraceConfig::converged(),
        }
    }
}

/// The name of the limits.
impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A text that names no limits.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is neither 'r2d1' nor 'converged'")]
pub struct UnknownLimits(pub String);

/// Reads `r2d1` or `converged`.
impl FromStr for Limits {
    type Err = UnknownLimits;

    fn from_str(text: &str) -> Result<Self, UnknownLimits> {
        let mut all = Self::ALL.into_iter();
        let found = all.find(|limits| limits.name() == text);
        found.ok_or_else(|| UnknownLimits(text.into()))
    }
}
