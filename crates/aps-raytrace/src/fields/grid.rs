//! The pixels that fields are computed at.

use glam::DVec2;

use super::error::FieldError;
use crate::scene::Area;

/// Largest number of pixels: a transmitter's fields take 6 bytes a pixel, and 42 while they are made.
const MAX_PIXELS: usize = 1 << 22;

/// Largest magnitude of a coordinate \[m\], as for terminals.
const MAX_COORDINATE_M: f64 = 1e9;

/// A grid of square pixels; rows run along y. A field has at a pixel the value at the pixel's centre.
///
/// The default covers a RadioMapSeer map by 256 x 256 pixels of 1 m, with centres at half metres: no wall between whole
/// metres along an axis runs through one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldGrid {
    /// Centre of the pixel in column 0 and row 0 \[m\].
    pub first_m: DVec2,
    /// Side of a pixel \[m\].
    pub pixel_m: f64,
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
}

impl Default for FieldGrid {
    fn default() -> Self {
        Self::over(Area::RADIOMAPSEER, 1.0)
    }
}

impl FieldGrid {
    /// The pixels that cover an area, the first in its lower left corner. What is wrong with the area or the pixel is told by
    /// those that take a grid.
    #[must_use]
    pub fn over(area: Area, pixel_m: f64) -> Self {
        // Far beyond the limit, and NaN, become sizes that are refused.
        let count = |extent_m: f64| (extent_m / pixel_m - 1e-9).ceil().clamp(0.0, 1e9) as usize;
        let extent = area.max - area.min;
        Self {
            first_m: area.min + 0.5 * pixel_m,
            pixel_m,
            width: count(extent.x),
            height: count(extent.y),
        }
    }

    /// Number of pixels.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.width.saturating_mul(self.height)
    }

    /// Centre of a pixel \[m\], by its index: row times width, plus column.
    #[must_use]
    pub fn centre(&self, pixel: usize) -> DVec2 {
        let (x, y) = (pixel % self.width, pixel / self.width);
        self.first_m + DVec2::new(x as f64, y as f64) * self.pixel_m
    }

    /// Index of the pixel around a position \[m\]; `None` outside of the grid. A position between pixels belongs to the one
    /// of larger coordinates.
    #[must_use]
    pub fn pixel_at(&self, position: DVec2) -> Option<usize> {
        let at = ((position - self.first_m) / self.pixel_m + 0.5).floor();
        let end = DVec2::new(self.width as f64, self.height as f64);
        let is_inside = at.cmpge(DVec2::ZERO).all() && at.cmplt(end).all();
        is_inside.then(|| at.y as usize * self.width + at.x as usize)
    }

    pub(super) fn check(&self) -> Result<(), FieldError> {
        let corners = [self.first_m, self.last_m()];
        let is_near = |p: DVec2| p.is_finite() && p.abs().max_element() <= MAX_COORDINATE_M;
        let problem = if !(self.pixel_m > 0.0 && self.pixel_m.is_finite()) {
            "the side of a pixel must be finite and positive"
        } else if self.width == 0 || self.height == 0 {
            "there must be at least one row and one column"
        } else if self.pixels() > MAX_PIXELS {
            "there may be at most 2^22 pixels; take larger ones"
        } else if !corners.into_iter().all(is_near) {
            "pixels must be at finite positions within 1e9 m"
        } else {
            return Ok(());
        };
        Err(FieldError::Grid {
            width: self.width,
            height: self.height,
            pixel_m: self.pixel_m,
            first_m: self.first_m,
            problem,
        })
    }

    /// Centre of the pixel in the last column and row \[m\].
    pub(super) fn last_m(&self) -> DVec2 {
        let steps = DVec2::new(self.width as f64, self.height as f64) - 1.0;
        self.first_m + steps * self.pixel_m
    }

    pub(super) fn moved(self, by: DVec2) -> Self {
        Self {
            first_m: self.first_m + by,
            ..self
        }
    }
}
