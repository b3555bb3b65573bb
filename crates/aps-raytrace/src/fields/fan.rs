//! The directions and ranges at which a receiver looks at the city.

use std::f64::consts::TAU;

use glam::DVec2;

use super::error::FieldError;

/// Largest number of positions of one fan: a link has twelve numbers at each.
const MAX_POSITIONS: usize = 1 << 22;

/// Most walls that a ray is reflected at: what remains of a byte beside other marks.
const MAX_BOUNCES: usize = 100;

/// Rays from a receiver: their directions, the unfolded ranges at which each is looked at, and the reflections it follows.
///
/// Ray i leaves at an angle of (i + 1/2) turns over the number of directions: none along an axis, where walls and corners
/// between whole metres lie. The directions mirrored along x or y are directions again.
#[derive(Debug, Clone, PartialEq)]
pub struct Fan {
    /// Number of directions, a multiple of four.
    pub directions: usize,
    /// Unfolded distances from the receiver, rising \[m\].
    pub ranges_m: Vec<f64>,
    /// Reflections after which a ray ends at the next wall.
    pub max_bounces: usize,
    /// Samples of each straight piece.
    pub samples: usize,
}

impl Default for Fan {
    /// 180 directions, 40 ranges from 1 to 320 m, three bounces.
    fn default() -> Self {
        Self {
            directions: 180,
            ranges_m: Self::log_spaced(40, 1.0, 320.0),
            max_bounces: 3,
            samples: 8,
        }
    }
}

impl Fan {
    /// Returns ranges of equal ratio from the nearest to the farthest, both included \[m\].
    #[must_use]
    pub fn log_spaced(count: usize, nearest_m: f64, farthest_m: f64) -> Vec<f64> {
        let steps = count.saturating_sub(1).max(1) as f64;
        let ratio = (farthest_m / nearest_m).ln();
        (0..count)
            .map(|i| nearest_m * (ratio * i as f64 / steps).exp())
            .collect()
    }

    /// Number of positions: ranges times directions.
    #[must_use]
    pub fn positions(&self) -> usize {
        self.directions.saturating_mul(self.ranges_m.len())
    }

    /// Angle of a ray, counter-clockwise from x \[rad\], in (0, 2 pi).
    #[must_use]
    pub fn angle_rad(&self, direction: usize) -> f64 {
        (direction as f64 + 0.5) * TAU / self.directions as f64
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

    pub(super) fn check(&self) -> Result<(), FieldError> {
        let rises = |pair: &[f64]| pair[0] < pair[1];
        let is_range = |r: &f64| r.is_finite() && *r > 0.0;
        let problem = if self.directions == 0 || !self.directions.is_multiple_of(4) {
            "the number of directions must be a multiple of four, and not zero"
        } else if self.ranges_m.is_empty() {
            "there must be at least one range"
        } else if self.positions() > MAX_POSITIONS {
            "there may be at most 2^22 positions"
        } else if !self.ranges_m.iter().all(is_range) || !self.ranges_m.windows(2).all(rises) {
            "ranges must be finite, positive and rising"
        } else if self.max_bounces > MAX_BOUNCES {
            "a ray follows at most 100 reflections"
        } else {
            return Ok(());
        };
        Err(FieldError::Fan {
            directions: self.directions,
            ranges: self.ranges_m.len(),
            problem,
        })
    }
}
