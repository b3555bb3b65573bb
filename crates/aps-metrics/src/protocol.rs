//! The two definitions of the benchmark's metrics, and every choice in which they differ.

use std::fmt;

use crate::peaks::Topology;

/// Tolerances of the benchmark's hit and recall columns \[deg\].
pub const TOLERANCES_DEG: [f64; 2] = [2.0, 4.0];

/// The definition of the metrics to score under.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Protocol {
    /// The Map2APS paper's text: circular angles on a grid of \[-180, 180) deg.
    #[default]
    Paper,
    /// The Python code released with the paper: bins counted as degrees, no wrap.
    Released,
}

/// Angles of the bins of a spectrum. Only circular distances and mirror twins depend on them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum AngleGrid {
    /// -180 deg + j * 360 / n for n bins: one turn is n bins.
    HalfOpen,
    /// -180 deg + j * 360 / (n - 1): first and last bin are the same direction, one turn is
    /// n - 1 bins.
    Closed,
}

impl AngleGrid {
    /// Number of bins after which directions repeat; at least 1.
    pub fn bins_per_turn(self, bins: usize) -> usize {
        match self {
            AngleGrid::HalfOpen => bins.max(1),
            AngleGrid::Closed => bins.saturating_sub(1).max(1),
        }
    }
}

/// Angle counted for a distance of one bin \[deg\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum BinWidth {
    /// The step of the grid.
    Grid,
    /// 1 deg, whatever the grid.
    OneDegree,
}

/// Scaling of a spectrum before the search for peaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum PeakScaling {
    /// x / max(x). A spectrum whose maximum is not positive has no peaks.
    Maximum,
    /// x / (max(x) + 1e-8), whatever the sign: a spectrum that is negative everywhere is turned
    /// upside down, as the released code does. If the divisor is 0 there are no peaks.
    MaximumPlusEpsilon,
}

/// Predicted peaks that may match a true one when recall is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum RecallCandidates {
    /// Every predicted peak.
    AllPeaks,
    /// Dominant predicted peaks only.
    DominantPeaks,
}

/// Definition of the metrics, choice by choice. Start from [`Protocol::definition`] and change
/// fields to see the effect of a choice:
///
/// ```
/// use aps_metrics::{Definition, Protocol, Topology};
///
/// // The released code's metrics, were its distances circular.
/// let definition = Definition {
///     distance: Topology::Ring,
///     ..Protocol::Released.definition()
/// };
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Definition {
    /// Directions of the bins.
    pub grid: AngleGrid,
    /// Arrangement of the bins in the search for peaks. On a [`AngleGrid::Closed`] grid the ring
    /// leaves out the last bin, which repeats the first.
    pub peaks: Topology,
    /// Arrangement of the bins for distances between peaks: on a ring they wrap at +-180 deg.
    /// Mirror-aware distances always wrap.
    pub distance: Topology,
    /// Angle counted for a distance of one bin.
    pub bin_width: BinWidth,
    /// Scaling of a spectrum before the search for peaks.
    pub peak_scaling: PeakScaling,
    /// Smallest prominence of a peak, as a share of the scaled maximum.
    pub min_prominence: f64,
    /// Smallest share of the sum of all peak heights that makes a peak dominant.
    pub min_contribution: f64,
    /// Predicted peaks that count for recall.
    pub recall_candidates: RecallCandidates,
}

impl Protocol {
    /// Both protocols.
    pub const ALL: [Self; 2] = [Self::Paper, Self::Released];

    /// Returns the choices of this protocol.
    pub fn definition(self) -> Definition {
        match self {
            Protocol::Paper => Definition {
                grid: AngleGrid::HalfOpen,
                peaks: Topology::Ring,
                distance: Topology::Ring,
                bin_width: BinWidth::Grid,
                peak_scaling: PeakScaling::Maximum,
                min_prominence: 0.05,
                min_contribution: 0.1,
                recall_candidates: RecallCandidates::AllPeaks,
            },
            Protocol::Released => Definition {
                grid: AngleGrid::Closed,
                peaks: Topology::Line,
                distance: Topology::Line,
                bin_width: BinWidth::OneDegree,
                peak_scaling: PeakScaling::MaximumPlusEpsilon,
                min_prominence: 0.05,
                min_contribution: 0.1,
                recall_candidates: RecallCandidates::DominantPeaks,
            },
        }
    }

    /// Returns the protocol's name: `paper` or `released`.
    pub fn name(self) -> &'static str {
        match self {
            Protocol::Paper => "paper",
            Protocol::Released => "released",
        }
    }
}

/// The name of the protocol.
impl fmt::Display for Protocol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(feature = "label")]
impl From<aps_label::Protocol> for Protocol {
    /// Scores labels by the definition of their own protocol.
    fn from(protocol: aps_label::Protocol) -> Self {
        match protocol {
            aps_label::Protocol::Paper => Protocol::Paper,
            aps_label::Protocol::Released => Protocol::Released,
        }
    }
}

impl From<Protocol> for Definition {
    fn from(protocol: Protocol) -> Self {
        protocol.definition()
    }
}
