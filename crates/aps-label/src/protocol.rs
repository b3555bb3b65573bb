//! The two published definitions of a label.

use std::fmt;
use std::str::FromStr;

use crate::Axis;

/// Send power the released code assumes \[dBm\].
const RELEASED_SEND_DBM: f64 = 1.0;

/// The floor of both protocols, as linear power: 10 log10(1e-35) = -350 dB.
pub(crate) const FLOOR_POWER: f64 = 1e-35;

/// Definition of the label that is computed.
///
/// The benchmark's paper and the Python code released with it differ; each is offered whole.
///
/// | | `Paper` | `Released` |
/// |---|---|---|
/// | power of a path | \|a\|^2 = 10^(gain_db/10) | dBm = 1 - loss_dB, as if 1 dBm were sent |
/// | paths left out | none that f64 could show (see [`NEGLIGIBLE_DB`]) | loss <= 0 dB or > 310 dB |
/// | angle axis | \[-180, 180) deg, step 2 deg | linspace(-180, 180, 180) deg, both ends |
/// | arrival angle | towards the last interaction | direction of travel: half a turn further |
/// | maximum over tau | continuous | over the sampled delay axis |
/// | default delay axis | 401 points, 0 to 1000 ns (PDP only) | 128 points, 0 to 1000 ns |
/// | dB | 10 log10 max(Q, 1e-35 p_max) | 10 log10(Q + 1e-35) |
///
/// `Paper` names no floor; the one here keeps a bin finite where every path has a zero of the array
/// response. It is relative to the strongest path, so that scaling all gains shifts a label and
/// changes nothing else.
///
/// ```
/// use aps_label::{LabelConfig, Protocol};
///
/// let protocol: Protocol = "released".parse()?;
/// assert_eq!(LabelConfig::of(protocol), LabelConfig::released());
/// # Ok::<(), aps_label::ParseProtocolError>(())
/// ```
///
/// [`NEGLIGIBLE_DB`]: crate::NEGLIGIBLE_DB
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Protocol {
    /// As the paper defines it. The default: its labels lose nothing to a grid of delays.
    #[default]
    Paper,
    /// As the released Python code computes it.
    Released,
}

/// A protocol name that is neither `paper` nor `released`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("unknown protocol `{0}`: use `paper` or `released`")]
pub struct ParseProtocolError(String);

impl Protocol {
    /// Both protocols.
    pub const ALL: [Self; 2] = [Self::Paper, Self::Released];

    /// Name on the command line and in files: `paper` or `released`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Released => "released",
        }
    }

    /// Power that the protocol takes as sent \[dBm in `Released`, dB relative to itself in `Paper`\]: what a label's
    /// powers exceed the sums of path gains by.
    pub fn sent_power_db(self) -> f64 {
        match self {
            Self::Paper => 0.0,
            Self::Released => RELEASED_SEND_DBM,
        }
    }

    /// Angles of the bins \[deg\].
    pub fn angle_axis_deg(self) -> Axis {
        match self {
            Self::Paper => Axis::ANGLE_PAPER_DEG,
            Self::Released => Axis::ANGLE_RELEASED_DEG,
        }
    }
}

impl FromStr for Protocol {
    type Err = ParseProtocolError;

    /// Reads `paper` or `released`, in any case.
    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name.to_ascii_lowercase().as_str() {
            "paper" => Ok(Self::Paper),
            "released" => Ok(Self::Released),
            _ => Err(ParseProtocolError(name.to_owned())),
        }
    }
}

impl fmt::Display for Protocol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for protocol in Protocol::ALL {
            assert_eq!(protocol.to_string().parse(), Ok(protocol));
        }
        assert_eq!("Paper".parse(), Ok(Protocol::Paper));
        let error = "papier".parse::<Protocol>().unwrap_err();
        assert_eq!(
            error.to_string(),
            "unknown protocol `papier`: use `paper` or `released`"
        );
    }
}
