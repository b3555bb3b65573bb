//! Verdicts: one line where a number decides something.

use serde::{Deserialize, Serialize};

use crate::numbers::small;

/// A claim, and the numbers that decide it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// The decision.
    pub outcome: Outcome,
    /// The claim.
    pub claim: String,
    /// The numbers behind it; empty for none.
    pub evidence: String,
}

/// A decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The claim holds.
    Pass,
    /// The claim does not hold.
    Fail,
}

impl Outcome {
    /// The decision in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "PASS",
            Self::Fail => "FAIL",
        }
    }
}

impl Verdict {
    /// A claim that holds or does not.
    pub fn decided(holds: bool, claim: impl Into<String>, evidence: impl Into<String>) -> Self {
        Self {
            outcome: if holds { Outcome::Pass } else { Outcome::Fail },
            claim: claim.into(),
            evidence: evidence.into(),
        }
    }

    /// A value that must not be above a bound, both in `unit`. A value that is no number fails.
    pub fn bound(claim: impl Into<String>, value: f64, most: f64, unit: &str) -> Self {
        let space = if unit.is_empty() { "" } else { " " };
        let evidence = format!("{}{space}{unit}, bound {}", small(value), small(most));
        Self::decided(value <= most, claim, evidence)
    }

    /// Claim and numbers in a line, without the decision.
    pub(super) fn line(&self) -> String {
        match self.evidence.is_empty() {
            true => self.claim.clone(),
            false => format!("{}: {}", self.claim, self.evidence),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_is_held_up_to_itself_and_by_numbers_alone() {
        let outcome = |value: f64| Verdict::bound("", value, 2.0, "dB").outcome;
        assert_eq!(outcome(2.0), Outcome::Pass);
        assert_eq!(outcome(2.0001), Outcome::Fail);
        assert_eq!(outcome(f64::NAN), Outcome::Fail);
    }
}
