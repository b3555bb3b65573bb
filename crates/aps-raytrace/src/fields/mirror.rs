//! Mirror images of fields: the same numbers in another order.

/// Axes along which a map is mirrored, about the middle of its grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Mirror {
    /// Mirrors along x: the first column changes places with the last one.
    pub x: bool,
    /// Mirrors along y: the first row changes places with the last one.
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

    /// Returns the pixel of the map whose field the mirrored map has at `pixel`, on a grid of so many columns and rows; its
    /// own inverse.
    #[must_use]
    pub fn pixel(self, pixel: usize, width: usize, height: usize) -> usize {
        let turn = |at: usize, count: usize, is_mirrored: bool| match is_mirrored {
            true => count - 1 - at,
            false => at,
        };
        turn(pixel / width, height, self.y) * width + turn(pixel % width, width, self.x)
    }

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

    /// The sign that angles turn by: -1 when left and right change places.
    pub(super) fn turn(self) -> f64 {
        if self.x == self.y { 1.0 } else { -1.0 }
    }
}
