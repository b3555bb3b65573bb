//! Mirror images of a link: the same values in another order.

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
}
