//! Path records, the result of a trace.
//!
//! Azimuths are angles in the plane, counter-clockwise from the x axis, in (-pi, pi]. The
//! departure azimuth points from the transmitter to the first interaction, the arrival azimuth
//! from the receiver to the last one; without interactions, to the other terminal.

use std::cmp::Ordering;

use glam::DVec2;
use num_complex::Complex64;
use smallvec::SmallVec;

use crate::material::SPEED_OF_LIGHT_M_PER_S;

/// Kind of interaction of a wave at one point of its path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum InteractionKind {
    /// Specular reflection; `id` is a wall.
    Reflection,
    /// Diffraction; `id` is a corner, the start of the wall with the same id.
    Diffraction,
}

/// One interaction of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Interaction {
    /// Kind of the interaction.
    pub kind: InteractionKind,
    /// Id of the wall or corner.
    pub id: u32,
    /// Position \[m\].
    pub point: DVec2,
}

/// The interactions of a path from transmitter to receiver; a slice for all purposes, stored
/// inline up to four.
pub type Interactions = SmallVec<[Interaction; 4]>;

/// One propagation path of a link.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PathRecord {
    /// Interactions from transmitter to receiver; none for the line of sight, and none at all of a
    /// [`Link::without_interactions`](crate::Link::without_interactions).
    pub interactions: Interactions,
    /// Unfolded length \[m\].
    pub length_m: f64,
    /// Length over the speed of light \[s\].
    pub delay_s: f64,
    /// Direction of departure, from the transmitter \[rad\].
    pub departure_azimuth_rad: f64,
    /// Direction of arrival, from the receiver towards the last interaction \[rad\].
    pub arrival_azimuth_rad: f64,
    /// Complex amplitude between isotropic antennas, e^{-j k L} included; its squared magnitude
    /// is the power gain.
    pub gain: Complex64,
}

impl PathRecord {
    /// Assembles a record from geometry and gain.
    pub(crate) fn new(
        tx: DVec2,
        rx: DVec2,
        interactions: Interactions,
        length_m: f64,
        gain: Complex64,
    ) -> Self {
        let first = interactions.first().map_or(rx, |i| i.point);
        let last = interactions.last().map_or(tx, |i| i.point);
        let azimuths_rad = [azimuth(first - tx), azimuth(last - rx)];
        Self::with_azimuths(azimuths_rad, interactions, length_m, gain)
    }

    /// Assembles a record whose azimuths of departure and arrival are known.
    pub(crate) fn with_azimuths(
        [departure_azimuth_rad, arrival_azimuth_rad]: [f64; 2],
        interactions: Interactions,
        length_m: f64,
        gain: Complex64,
    ) -> Self {
        Self {
            interactions,
            length_m,
            delay_s: length_m / SPEED_OF_LIGHT_M_PER_S,
            departure_azimuth_rad,
            arrival_azimuth_rad,
            gain,
        }
    }

    /// Power gain |a|^2, linear; its inverse is the path loss.
    #[must_use]
    pub fn power(&self) -> f64 {
        self.gain.norm_sqr()
    }

    /// Power gain 20 log10 |a| \[dB\]; negative of the path loss. Minus infinity for gain 0.
    #[must_use]
    pub fn gain_db(&self) -> f64 {
        10.0 * self.power().log10()
    }

    /// Returns true when the path has no interactions: nothing lies between the terminals. It means nothing for a path of a
    /// [`Link::without_interactions`](crate::Link::without_interactions).
    #[must_use]
    pub fn is_line_of_sight(&self) -> bool {
        self.interactions.is_empty()
    }

    /// The order in which a link lists its paths: by length, then by interactions.
    #[must_use]
    pub fn canonical_order(&self, other: &Self) -> Ordering {
        let key = |i: &Interaction| (i.kind, i.id);
        let by_length = self.length_m.total_cmp(&other.length_m);
        by_length.then_with(|| {
            let others = other.interactions.iter().map(key);
            self.interactions.iter().map(key).cmp(others)
        })
    }
}

/// Angle of a direction in (-pi, pi].
pub(crate) fn azimuth(direction: DVec2) -> f64 {
    // atan2 tells -0 from 0; a direction along negative x must not depend on that.
    let angle = direction.to_angle();
    if angle == -std::f64::consts::PI {
        std::f64::consts::PI
    } else {
        angle
    }
}
