//! Limits of the paths in labels, by name.

use std::fmt;
use std::str::FromStr;

use aps_raytrace::TraceConfig;
use serde::{Deserialize, Serialize};

/// Limits of the paths that labels are made of.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Limits {
    /// 5 reflections, 2 diffractions, paths within 20 dB of the strongest ([`TraceConfig::converged`]): further reflections and weaker
    /// paths change labels by 1 dB in the mean.
    #[default]
    Converged,
    /// 2 reflections, 1 diffraction, paths within 60 dB ([`TraceConfig::default`]).
    R2d1,
}

impl Limits {
    /// Every set of limits, the default first.
    pub const ALL: [Self; 2] = [Self::Converged, Self::R2d1];

    /// `converged` or `r2d1`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::R2d1 => "r2d1",
        }
    }

    /// The settings of the tracer.
    pub fn config(self) -> TraceConfig {
        match self {
            Self::Converged => TraceConfig::converged(),
            Self::R2d1 => TraceConfig::default(),
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
#[error("'{0}' is neither 'converged' nor 'r2d1'")]
pub struct UnknownLimits(pub String);

/// Reads `converged` or `r2d1`.
impl FromStr for Limits {
    type Err = UnknownLimits;

    fn from_str(text: &str) -> Result<Self, UnknownLimits> {
        let mut all = Self::ALL.into_iter();
        let found = all.find(|limits| limits.name() == text);
        found.ok_or_else(|| UnknownLimits(text.into()))
    }
}

/// Tells if paths may have a leg from corner to corner, which alone takes a slope along.
pub(crate) fn has_legs_between_corners(max_diffractions: usize, max_interactions: usize) -> bool {
    max_diffractions.min(max_interactions) > 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_have_one_name_each_and_the_settings_that_are_documented() {
        for limits in Limits::ALL {
            assert_eq!(limits.name().parse(), Ok(limits));
            assert_eq!(serde_json::to_value(limits).unwrap(), limits.name());
        }
        let values = Limits::ALL.map(|limits| {
            let config = limits.config();
            let most = [config.max_reflections, config.max_diffractions];
            (most, config.max_interactions, config.dynamic_range_db)
        });
        let expected = [([5, 2], 7, Some(20.0)), ([2, 1], 3, Some(60.0))];
        assert_eq!(values, expected);
        let refused = "r3d2".parse::<Limits>().unwrap_err();
        assert_eq!(
            refused.to_string(),
            "'r3d2' is neither 'converged' nor 'r2d1'"
        );
    }
}
