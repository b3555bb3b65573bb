//! Mirror images of maps.

use super::{Link, Rasters};

/// Mirror image of a map: the axes along which it is mirrored, about its middle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Mirror {
    /// Mirrors along x: distances from one end become distances from the other end.
    pub x: bool,
    /// Mirrors along y likewise.
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
}

impl Rasters<'_> {
    /// Number of maps.
    pub fn maps(&self) -> usize {
        let of_map = self.height.saturating_mul(self.width);
        self.pixels.len().checked_div(of_map).unwrap_or(0)
    }

    /// Returns the position of the last pixel (x, y) \[m\], with which position 0 changes places in a mirror image.
    pub fn far_end_m(&self) -> [f64; 2] {
        [self.width, self.height].map(|side| (side as f64 - 1.0) * self.metres_per_pixel)
    }

    /// Returns the pixels of all maps in each of [`Mirror::ALL`]: first the maps as they are, then all in the first mirror
    /// image, and so on. O(pixels).
    pub fn mirrored(&self) -> Vec<f32> {
        let mut all = Vec::with_capacity(Mirror::ALL.len() * self.pixels.len());
        if self.maps() == 0 {
            return all;
        }
        for mirror in Mirror::ALL {
            for map in self.pixels.chunks_exact(self.height * self.width) {
                let rows = map.chunks_exact(self.width);
                let mut push = |row: &[f32]| match mirror.x {
                    true => all.extend(row.iter().rev()),
                    false => all.extend(row),
                };
                match mirror.y {
                    true => rows.rev().for_each(&mut push),
                    false => rows.for_each(&mut push),
                }
            }
        }
        all
    }
}

impl Link {
    /// Returns the link in number `image` of [`Mirror::ALL`], among the maps of [`Rasters::mirrored`].
    ///
    /// # Panics
    /// When there is no such image.
    pub fn mirrored(self, image: usize, maps: usize, far_end_m: [f64; 2]) -> Self {
        let mirror = Mirror::ALL[image];
        let turn = |end_m: [f64; 2]| {
            [(0, mirror.x), (1, mirror.y)].map(|(axis, is_mirrored)| match is_mirrored {
                true => far_end_m[axis] - end_m[axis],
                false => end_m[axis],
            })
        };
        Self {
            map: self.map + (image * maps) as u32,
            tx_m: turn(self.tx_m),
            rx_m: turn(self.rx_m),
        }
    }
}
