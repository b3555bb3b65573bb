//! A wall as the rows of an image meet it.

use robust::{Coord, orient2d};

use super::RasterGrid;

/// The place where an outline crosses a row.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Crossing {
    pub row: usize,
    /// First pixel whose segment reaches beyond it.
    pub first: i64,
    /// Last pixel whose segment begins before it.
    pub last: i64,
    /// 1 upwards, -1 downwards.
    pub step: i32,
}

/// A wall, with its ends ordered by `y` \[m\].
pub struct RasterWall {
    low: [f64; 2],
    high: [f64; 2],
    step: i32,
    grid: RasterGrid,
}

impl RasterWall {
    pub fn between(a: [f64; 2], b: [f64; 2], grid: RasterGrid) -> Self {
        let (low, high, step) = match a[1] <= b[1] {
            true => (a, b, 1),
            false => (b, a, -1),
        };
        Self {
            low,
            high,
            step,
            grid,
        }
    }

    fn y_m(&self, row: usize) -> f64 {
        row as f64 * self.grid.metres_per_pixel
    }

    /// Rows of the image that the wall reaches, both ends included.
    pub fn rows(&self) -> std::ops::Range<usize> {
        let height = self.grid.height;
        // The quotient is rounded: one row more each way, then the rows themselves decide.
        let row = |y: f64, margin: f64| {
            (y / self.grid.metres_per_pixel + margin).clamp(0.0, height as f64) as usize
        };
        let (mut first, mut end) = (row(self.low[1], -1.0), row(self.high[1], 2.0));
        while first < end && self.y_m(first) < self.low[1] {
            first += 1;
        }
        while first < end && self.y_m(end - 1) > self.high[1] {
            end -= 1;
        }
        first..end
    }

    /// First and last pixel that the wall touches in a row it reaches.
    pub fn pixels_at(&self, row: usize) -> (i64, i64) {
        if self.low[1] == self.high[1] {
            let (a, b) = (self.low[0], self.high[0]);
            let [left, right] = [a.min(b), a.max(b)];
            let first = self.first_pixel(left, |x| x > left);
            (first, self.last_pixel(right, |x| x < right))
        } else {
            self.crossing_pixels_at(row)
        }
    }

    /// The crossing of a row, counted at the lower end but not at the upper one: a vertex between two walls counts once.
    pub fn crossing_at(&self, row: usize) -> Option<Crossing> {
        let (first, last) = (self.y_m(row) < self.high[1]).then(|| self.crossing_pixels_at(row))?;
        Some(Crossing {
            row,
            first,
            last,
            step: self.step,
        })
    }

    /// First and last pixel that touch the point where the wall, not horizontal, crosses a row.
    fn crossing_pixels_at(&self, row: usize) -> (i64, i64) {
        let ([x0, y0], [x1, y1]) = (self.low, self.high);
        let y = self.y_m(row);
        let x = x0 + (y - y0) / (y1 - y0) * (x1 - x0);
        let coord = |[x, y]: [f64; 2]| Coord { x, y };
        // Positive to the left of the wall, which points upwards.
        let side = |x: f64| orient2d(coord(self.low), coord(self.high), coord([x, y]));
        let first = self.first_pixel(x, |x| side(x) < 0.0);
        (first, self.last_pixel(x, |x| side(x) > 0.0))
    }

    /// The first pixel of the row whose right end is beyond the place at about `x` \[m\], as `is_beyond` decides;
    /// the width where none is.
    fn first_pixel(&self, x: f64, is_beyond: impl Fn(f64) -> bool) -> i64 {
        let right_m = |pixel: i64| (pixel as f64 + 0.5) * self.grid.metres_per_pixel;
        let width = self.grid.width as i64;
        let guess = (x / self.grid.metres_per_pixel - 0.5).floor() + 1.0;
        let mut pixel = guess.clamp(0.0, width as f64) as i64;
        while pixel > 0 && is_beyond(right_m(pixel - 1)) {
            pixel -= 1;
        }
        while pixel < width && !is_beyond(right_m(pixel)) {
            pixel += 1;
        }
        pixel
    }

    /// The last pixel of the row whose left end is before the place at about `x` \[m\], as `is_before` decides; -1
    /// where none is.
    fn last_pixel(&self, x: f64, is_before: impl Fn(f64) -> bool) -> i64 {
        let left_m = |pixel: i64| (pixel as f64 - 0.5) * self.grid.metres_per_pixel;
        let end = self.grid.width as i64 - 1;
        let guess = (x / self.grid.metres_per_pixel + 0.5).ceil() - 1.0;
        let mut pixel = guess.clamp(-1.0, end as f64) as i64;
        while pixel < end && is_before(left_m(pixel + 1)) {
            pixel += 1;
        }
        while pixel >= 0 && !is_before(left_m(pixel)) {
            pixel -= 1;
        }
        pixel
    }
}
