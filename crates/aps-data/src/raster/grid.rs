//! The grid of an image: its pixels as points of the plane.

use serde::{Deserialize, Serialize};

/// Largest side of an image \[pixels\].
const MAX_SIDE: usize = 1 << 14;

/// Largest distance of a position outside of the image \[m\].
const MARGIN_M: f64 = 1e-3;

/// The pixels of a raster: pixel `(x, y)` is the point `(x, y) * metres_per_pixel`.
///
/// The default is that of the released data: 256 x 256 pixels of 1 m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RasterGrid {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Distance between neighbouring pixels \[m\].
    pub metres_per_pixel: f64,
}

impl Default for RasterGrid {
    fn default() -> Self {
        RasterGrid {
            width: 256,
            height: 256,
            metres_per_pixel: 1.0,
        }
    }
}

impl RasterGrid {
    /// A square image of `side` pixels over a square map of `extent_m` \[m\].
    pub fn square(side: usize, extent_m: f64) -> Self {
        RasterGrid {
            width: side,
            height: side,
            metres_per_pixel: extent_m / side as f64,
        }
    }

    /// Width and height of the map that the image shows \[m\].
    pub fn size_m(&self) -> [f64; 2] {
        [self.width, self.height].map(|pixels| pixels as f64 * self.metres_per_pixel)
    }

    /// Tells if a position \[m\] is on the image, or within a millimetre of it: positions from elsewhere are rounded.
    pub fn holds(&self, position_m: [f64; 2]) -> bool {
        let on_axis = |(x, size): (f64, f64)| (-MARGIN_M..=size + MARGIN_M).contains(&x);
        position_m.into_iter().zip(self.size_m()).all(on_axis)
    }

    pub(crate) fn problem(&self) -> Option<&'static str> {
        if ![self.width, self.height]
            .iter()
            .all(|side| (1..=MAX_SIDE).contains(side))
        {
            Some("a raster needs 1 to 16384 rows and columns")
        } else if !(self.metres_per_pixel > 0.0 && self.metres_per_pixel.is_finite()) {
            Some("a raster needs a finite, positive number of metres per pixel")
        } else {
            None
        }
    }
}
