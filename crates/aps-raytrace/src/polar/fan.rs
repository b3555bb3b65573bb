//! The directions in which a receiver looks at the city.

use std::f64::consts::TAU;

use glam::DVec2;

use super::error::PolarError;

/// Kinds of ways along a ray: straight from the transmitter; over one corner, which the transmitter lights straight, after one
/// reflection, or after two; over several corners.
pub const KINDS: usize = 5;

/// Largest number of straight pieces of all rays.
const MAX_PIECES: usize = 1 << 20;

/// Rays from a receiver: their directions, and the reflections they follow.
///
/// Ray i leaves at an angle of (i + 1/2) turns over the number of directions: none along an axis, where walls and corners
/// between whole metres lie. The directions mirrored along x or y are directions again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fan {
    /// Number of directions, a multiple of four.
    pub directions: usize,
    /// Reflections after which a ray ends at the next wall.
    pub max_bounces: usize,
}

impl Default for Fan {
    /// 720 directions, two bounces.
    fn default() -> Self {
        Self {
            directions: 720,
            max_bounces: 2,
        }
    }
}

impl Fan {
    /// Angle of a ray, counter-clockwise from x \[rad\], in (0, 2 pi).
    #[must_use]
    pub fn angle_rad(&self, direction: usize) -> f64 {
        (direction as f64 + 0.5) * self.step_rad()
    }

    /// Angle between neighbouring rays \[rad\].
    #[must_use]
    pub fn step_rad(&self) -> f64 {
        TAU / self.directions as f64
    }

    /// Number of kinds of ways along a ray: each kind with each number of bounces.
    #[must_use]
    pub fn way_kinds(&self) -> usize {
        KINDS.saturating_mul(self.max_bounces.saturating_add(1))
    }

    /// Number of straight pieces of all rays: one more than bounces, times directions.
    pub(super) fn pieces(&self) -> usize {
        (self.max_bounces.saturating_add(1)).saturating_mul(self.directions)
    }

    /// Unit vectors of all rays: those of the first quarter, and their mirror images to the bit.
    pub(super) fn unit_vectors(&self) -> Vec<DVec2> {
        let half = self.directions / 2;
        let quarter = half / 2;
        let first = |i: usize| DVec2::from_angle(self.angle_rad(i));
        let upper = |i: usize| match i < quarter {
            true => first(i),
            false => first(half - 1 - i) * DVec2::new(-1.0, 1.0),
        };
        let all = |i: usize| match i < half {
            true => upper(i),
            false => upper(self.directions - 1 - i) * DVec2::new(1.0, -1.0),
        };
        (0..self.directions).map(all).collect()
    }

    pub(super) fn check(&self) -> Result<(), PolarError> {
        let problem = if self.directions == 0 || !self.directions.is_multiple_of(4) {
            "the number of directions must be a multiple of four, and not zero"
        } else if self.pieces() > MAX_PIECES {
            "directions times one more than the bounces may be at most 2^20"
        } else {
            return Ok(());
        };
        Err(PolarError::Fan {
            directions: self.directions,
            max_bounces: self.max_bounces,
            problem,
        })
    }
}
