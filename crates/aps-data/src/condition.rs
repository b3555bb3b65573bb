//! Condition images: the input of a model for a link.
//!
//! Three planes of the raster's size: buildings, and a Gaussian spot at the transmitter and at the
//! receiver, exp(-d^2 / (2 sigma^2)) with d in pixels. They are never stored: 2.55 million of them
//! would take 2 TB, and a Gaussian in the plane is the product of two on a line, so that making one
//! costs about as much as reading it.

mod area;

use crate::raster::Raster;

/// Settings of condition images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConditionConfig {
    /// Standard deviation of the spots \[pixels of the raster\]; 20 in the released data. A spot of 0 or NaN is a point.
    pub sigma_px: f64,
    /// Rows and columns of an image, which shows the whole raster whatever its size; otherwise those of the raster.
    ///
    /// A pixel of a smaller image is the average of the raster over what it covers, and the spots shrink with the image. Position
    /// c, in pixels of a raster W wide, is at (c + 1/2) S / W - 1/2 in an image S wide. A size of 0 is taken as 1.
    pub image_size: Option<usize>,
}

impl Default for ConditionConfig {
    fn default() -> Self {
        ConditionConfig {
            sigma_px: 20.0,
            image_size: None,
        }
    }
}

/// Makes the condition images of one map's links.
///
/// ```
/// use aps_data::{ConditionConfig, ConditionImages, Raster, RasterGrid};
/// let open_ground = Raster::empty(RasterGrid::default())?;
/// let images = ConditionImages::new(&open_ground, ConditionConfig::default());
/// let batch = images.batch(&[([128.0, 10.0], [30.0, 40.0])]);
/// assert_eq!(batch.len(), 3 * 256 * 256);
/// assert_eq!(batch[(256 + 10) * 256 + 128], 1.0); // plane 1, row y = 10, column x = 128
/// # Ok::<(), aps_data::RasterError>(())
/// ```
#[derive(Debug, Clone)]
pub struct ConditionImages {
    buildings: Vec<f32>,
    metres_per_pixel: f64,
    along: [Along; 2],
}

/// Map from positions along x or y to pixels of an image.
#[derive(Debug, Clone, Copy)]
struct Along {
    /// Length of the image \[pixels\].
    pixels: usize,
    /// Pixels of the image a pixel of the raster.
    scale: f64,
    /// -1 / (2 sigma^2), sigma in pixels of the image.
    exponent: f64,
}

impl ConditionImages {
    /// Prepares the images of a map with these buildings.
    pub fn new(buildings: &Raster, config: ConditionConfig) -> Self {
        let grid = buildings.grid();
        let map: Vec<f32> = buildings.pixels().iter().copied().map(f32::from).collect();
        let size = config.image_size.map(|size| size.max(1));
        let along = |side: usize| {
            let pixels = size.unwrap_or(side);
            let scale = pixels as f64 / side as f64;
            let sigma = config.sigma_px * scale;
            Along {
                pixels,
                scale,
                // Never infinite, nor NaN: at no distance it is multiplied by 0.
                exponent: (-0.5 / (sigma * sigma)).max(f64::MIN),
            }
        };
        ConditionImages {
            buildings: match size {
                Some(size) => area::average(&map, [grid.height, grid.width], size),
                None => map,
            },
            metres_per_pixel: grid.metres_per_pixel,
            along: [along(grid.width), along(grid.height)],
        }
    }

    /// Returns the number of values of one image: 3 x height x width.
    pub fn image_len(&self) -> usize {
        3 * self.buildings.len()
    }

    /// The images of links given as (Tx, Rx) \[m\]: shape (links, 3, height, width), last axis
    /// fastest.
    pub fn batch(&self, links_m: &[([f64; 2], [f64; 2])]) -> Vec<f32> {
        let mut images = vec![0.0; links_m.len() * self.image_len()];
        for (image, &(tx_m, rx_m)) in images.chunks_exact_mut(self.image_len()).zip(links_m) {
            self.write(tx_m, rx_m, image);
        }
        images
    }

    /// Writes the image of one link into `image`: shape (3, height, width), last axis fastest.
    ///
    /// Each value is the product of two f64 exponentials rounded once: within one f32 rounding of
    /// exp of the summed exponent.
    ///
    /// # Panics
    /// When `image` is not [`ConditionImages::image_len`] long.
    pub fn write(&self, tx_m: [f64; 2], rx_m: [f64; 2], image: &mut [f32]) {
        assert_eq!(image.len(), self.image_len(), "an image of three planes");
        let (buildings, spots) = image.split_at_mut(self.buildings.len());
        buildings.copy_from_slice(&self.buildings);
        for (plane, centre_m) in spots
            .chunks_exact_mut(self.buildings.len())
            .zip([tx_m, rx_m])
        {
            let [x, y] = centre_m.map(|metres| metres / self.metres_per_pixel);
            let [along_x, along_y] = [self.along[0].spot(x), self.along[1].spot(y)];
            for (line, y) in plane.chunks_exact_mut(along_x.len()).zip(along_y) {
                for (value, x) in line.iter_mut().zip(&along_x) {
                    *value = (x * y) as f32;
                }
            }
        }
    }
}

impl Along {
    /// Computes a spot along this axis; `centre` is in pixels of the raster.
    fn spot(self, centre: f64) -> Vec<f64> {
        let centre = centre * self.scale + 0.5 * (self.scale - 1.0);
        let value = |pixel: usize| (self.exponent * (pixel as f64 - centre).powi(2)).exp();
        (0..self.pixels).map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::RasterGrid;

    #[test]
    fn a_spot_without_size_is_a_point() {
        let ground = Raster::empty(RasterGrid::square(3, 3.0)).unwrap();
        for sigma_px in [0.0, -0.0, 1e-200, f64::NAN] {
            let config = ConditionConfig {
                sigma_px,
                image_size: None,
            };
            let images = ConditionImages::new(&ground, config);
            let image = images.batch(&[([1.0, 0.0], [0.5, 0.5])]);
            let spot = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            assert_eq!((&image[9..18], &image[18..]), (&spot[..], &[0.0; 9][..]));
        }
    }
}
