//! Mirror images of maps, by their numbers.

use super::{Link, Rasters};

/// Number of images of a map, in their order: as it is, mirrored along x, along y and along both, about its middle.
pub const MIRROR_IMAGES: usize = 4;

/// Tells if image `image` of a map is mirrored along an axis: 0 for x, 1 for y.
pub(crate) fn is_mirrored(image: usize, axis: usize) -> bool {
    (image >> axis) & 1 == 1
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

    /// Returns the pixels of all maps in each of their [`MIRROR_IMAGES`]: first the maps as they are, then all in the first mirror
    /// image, and so on. O(pixels).
    pub fn mirrored(&self) -> Vec<f32> {
        let mut all = Vec::with_capacity(MIRROR_IMAGES * self.pixels.len());
        if self.maps() == 0 {
            return all;
        }
        for image in 0..MIRROR_IMAGES {
            for map in self.pixels.chunks_exact(self.height * self.width) {
                let rows = map.chunks_exact(self.width);
                let mut push = |row: &[f32]| match is_mirrored(image, 0) {
                    true => all.extend(row.iter().rev()),
                    false => all.extend(row),
                };
                match is_mirrored(image, 1) {
                    true => rows.rev().for_each(&mut push),
                    false => rows.for_each(&mut push),
                }
            }
        }
        all
    }
}

impl Link {
    /// Returns the link in image `image` of [`MIRROR_IMAGES`], among the maps of [`Rasters::mirrored`].
    ///
    /// # Panics
    /// When there is no such image.
    pub fn mirrored(self, image: usize, maps: usize, far_end_m: [f64; 2]) -> Self {
        assert!(image < MIRROR_IMAGES, "{image} of {MIRROR_IMAGES} images");
        let turn = |end_m: [f64; 2]| {
            [0, 1].map(|axis| match is_mirrored(image, axis) {
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
