//! Condition images: the input of a model for a link.
//!
//! Three planes of the raster's size: buildings, and a Gaussian spot at the transmitter and at the
//! receiver, exp(-d^2 / (2 sigma^2)) with d in pixels. They are never stored: 2.55 million of them
//! would take 2 TB, and a Gaussian in the plane is the product of two on a line, so that making one
//! costs about as much as reading it.

use crate::raster::Raster;

/// Settings of condition images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConditionConfig {
    /// Standard deviation of the spots \[pixels\]; positive. 20 in the released data.
    pub sigma_px: f64,
}

impl Default for ConditionConfig {
    fn default() -> Self {
        ConditionConfig { sigma_px: 20.0 }
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
    width: usize,
    height: usize,
    metres_per_pixel: f64,
    /// -1 / (2 sigma^2).
    exponent: f64,
}

impl ConditionImages {
    /// Prepares the images of a map with these buildings.
    pub fn new(buildings: &Raster, config: ConditionConfig) -> Self {
        let grid = buildings.grid();
        ConditionImages {
            buildings: buildings.pixels().iter().copied().map(f32::from).collect(),
            width: grid.width,
            height: grid.height,
            metres_per_pixel: grid.metres_per_pixel,
            exponent: -0.5 / (config.sigma_px * config.sigma_px),
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
            let [column, row] = centre_m.map(|metres| metres / self.metres_per_pixel);
            let along_x = self.spot(column, self.width);
            let along_y = self.spot(row, self.height);
            for (line, y) in plane.chunks_exact_mut(self.width).zip(along_y) {
                for (value, x) in line.iter_mut().zip(&along_x) {
                    *value = (x * y) as f32;
                }
            }
        }
    }

    fn spot(&self, centre: f64, pixels: usize) -> Vec<f64> {
        (0..pixels)
            .map(|pixel| (self.exponent * (pixel as f64 - centre).powi(2)).exp())
            .collect()
    }
}
