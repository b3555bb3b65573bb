//! Mirror images of a link: the same ways from other directions.

use super::link::{FEATURES, PER_WAY};

/// Axes along which a map is mirrored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Mirror {
    /// Mirrors along x: left and right change places.
    pub x: bool,
    /// Mirrors along y: up and down change places.
    pub y: bool,
}

impl Mirror {
    /// The map as it is, and its three mirror images.
    pub const ALL: [Self; 4] = [
        Self { x: false, y: false },
        Self { x: true, y: false },
        Self { x: false, y: true },
        Self { x: true, y: true },
    ];

    /// Returns the direction of the map's fan whose ray the mirrored map has at `direction`, out of so many; its own inverse.
    #[must_use]
    pub fn direction(self, direction: usize, directions: usize) -> usize {
        let turned = match self.x {
            true if direction < directions / 2 => directions / 2 - 1 - direction,
            true => directions + directions / 2 - 1 - direction,
            false => direction,
        };
        match self.y {
            true => directions - 1 - turned,
            false => turned,
        }
    }

    /// The sign that feature 2 of a [`PolarLink`](super::PolarLink) is multiplied by: -1 when left and right change places.
    #[must_use]
    pub fn turn(self) -> f64 {
        if self.x == self.y { 1.0 } else { -1.0 }
    }

    /// Turns the ways of a link, as [`PolarLink::ways`](super::PolarLink::ways) writes them for so many directions, into those of its
    /// mirror image, in the same order.
    ///
    /// # Panics
    /// When a way is of no direction, or the list not of whole ways.
    pub fn turn_ways(self, ways: &mut [f32], directions: usize) {
        if self == Self::default() {
            return;
        }
        let (ways, rest) = ways.as_chunks_mut::<PER_WAY>();
        assert!(rest.is_empty(), "{PER_WAY} numbers a way");
        for way in &mut *ways {
            let direction = way[FEATURES] as usize;
            assert!(
                direction < directions,
                "direction {direction} of {directions}"
            );
            way[2] *= self.turn() as f32;
            way[FEATURES] = self.direction(direction, directions) as f32;
        }
        // Kinds of a direction stay in their order.
        ways.sort_by(|p, q| p[FEATURES].total_cmp(&q[FEATURES]));
    }
}
