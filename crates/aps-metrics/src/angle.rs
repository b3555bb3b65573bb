//! Distances between directions given as bins, exact in half bins.
//!
//! A uniform linear array cannot tell theta from its mirror twin 180 deg - theta. On a grid that
//! starts at -180 deg the twin of bin j lies at bin (turn / 2 - j), modulo one turn: on the grid
//! with an odd number of bins a turn it falls half-way between two bins. Counting in half bins
//! keeps every position and every distance an integer.

use crate::peaks::Topology;
use crate::protocol::{BinWidth, Definition};

/// Measures distances on the grid of a definition.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AngleDistance {
    bins_per_turn: usize,
    wraps: bool,
    width: BinWidth,
}

impl AngleDistance {
    pub fn new(definition: &Definition, bins: usize) -> Self {
        Self {
            bins_per_turn: definition.grid.bins_per_turn(bins),
            wraps: definition.distance == Topology::Ring,
            width: definition.bin_width,
        }
    }

    /// Distance of two bins under the definition, in half bins.
    pub fn distance(&self, a: usize, b: usize) -> usize {
        if self.wraps {
            self.around(2 * a, 2 * b)
        } else {
            2 * a.abs_diff(b)
        }
    }

    /// Distance of `a` to the nearer of `b` and the mirror twin of `b`, in half bins. Always
    /// around the circle: on a line the twin of a direction near +-180 deg would lie far off.
    pub fn mirror_distance(&self, a: usize, b: usize) -> usize {
        let turn = 2 * self.bins_per_turn;
        let twin = self.bins_per_turn + turn - 2 * b;
        let twin = if twin < turn { twin } else { twin - turn };
        self.around(2 * a, 2 * b).min(self.around(2 * a, twin))
    }

    /// Shorter way around between two positions in half bins, 0 to one turn each.
    fn around(&self, a: usize, b: usize) -> usize {
        let turn = 2 * self.bins_per_turn;
        let way = a.abs_diff(b);
        way.min(turn - way)
    }

    /// Half bins as degrees.
    ///
    /// One exact product and one correctly rounded quotient: a distance of exactly delta is
    /// never taken for more than delta.
    pub fn degrees(&self, half_bins: usize) -> f64 {
        match self.width {
            BinWidth::Grid => half_bins as f64 * 180.0 / self.bins_per_turn as f64,
            BinWidth::OneDegree => half_bins as f64 / 2.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Protocol;

    #[test]
    fn paper_goes_around_in_steps_of_2_deg() {
        let paper = AngleDistance::new(&Protocol::Paper.definition(), 180);
        assert_eq!(paper.degrees(paper.distance(0, 179)), 2.0);
        assert_eq!(paper.degrees(paper.distance(0, 90)), 180.0);
        assert_eq!(paper.degrees(paper.distance(10, 50)), 80.0);
    }

    #[test]
    fn released_counts_bins_between_two_ends() {
        let released = AngleDistance::new(&Protocol::Released.definition(), 180);
        assert_eq!(released.degrees(released.distance(0, 179)), 179.0);
        assert_eq!(released.degrees(released.distance(10, 50)), 40.0);
    }

    #[test]
    fn mirror_twins_of_the_paper_grid() {
        // 30 deg is bin 105, its twin 150 deg is bin 165.
        let paper = AngleDistance::new(&Protocol::Paper.definition(), 180);
        assert_eq!(paper.mirror_distance(165, 105), 0);
        assert_eq!(paper.mirror_distance(105, 105), 0);
        // -170 deg (bin 5) and its twin 350 = -10 deg (bin 85).
        assert_eq!(paper.mirror_distance(85, 5), 0);
        // +-90 deg are their own twins.
        assert_eq!(paper.degrees(paper.mirror_distance(45, 135)), 180.0);
    }

    #[test]
    fn mirror_twins_of_the_released_grid_lie_between_bins() {
        let released = AngleDistance::new(&Protocol::Released.definition(), 180);
        // Bin 10 has its twin at 79.5, bin 0 = bin 179 = 180 deg at 89.5 (0 deg).
        assert_eq!(released.degrees(released.mirror_distance(79, 10)), 0.5);
        assert_eq!(released.degrees(released.mirror_distance(80, 10)), 0.5);
        assert_eq!(released.degrees(released.mirror_distance(89, 179)), 0.5);
        assert_eq!(released.degrees(released.mirror_distance(0, 179)), 0.0);
    }

    #[test]
    fn mirror_distance_is_symmetric() {
        for protocol in Protocol::ALL {
            for bins in [1, 2, 7, 36] {
                let angles = AngleDistance::new(&protocol.definition(), bins);
                for a in 0..bins {
                    for b in 0..bins {
                        let forth = angles.mirror_distance(a, b);
                        assert_eq!(forth, angles.mirror_distance(b, a));
                        assert!(forth <= angles.distance(a, b));
                    }
                }
            }
        }
    }
}
