//! Buildings as an image: 1 where a pixel touches a building, 0 elsewhere.
//!
//! # The rule
//!
//! Pixel (x, y) stands for the point (x, y) of the plane, in units of
//! [`RasterGrid::metres_per_pixel`]; rows run along y. A building is the closed region between its
//! rings (even-odd rule), walls included. A pixel is set when the open segment from (x - 1/2, y) to
//! (x + 1/2, y) meets a building: along a row nothing is missed, between rows the plane is sampled.
//!
//! Vertices are rounded to 1/256 of a pixel; from there on all arithmetic is in integers, so that
//! the image is the same on every machine. Integer vertices on a grid of 1 m stay as they are.
//!
//! # Agreement with the released data
//!
//! The released images were drawn by Pillow's `ImageDraw.polygon(fill=...)`, which follows the same
//! rule in single precision and adds pixels where walls meet at a narrow angle. On the paper's 51
//! maps, 1,257,661 pixels of buildings, the two differ in one pixel, at a narrow corner on map 41.
//! On random triangles with sides up to 40 pixels, far more pointed than buildings, Pillow sets
//! three pixels more in a thousand.

use serde::{Deserialize, Serialize};

/// Integer steps a pixel.
const STEPS: i128 = 256;

/// Largest coordinate \[steps\]: far outside any image, small enough for products in 128 bits.
const MAX_STEPS: f64 = (1_u64 << 40) as f64;

/// Largest side of an image \[pixels\].
const MAX_SIDE: usize = 1 << 14;

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

/// Why a raster could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RasterError {
    /// The grid has no pixels, too many, or no size.
    #[error("{problem}, got {grid:?}")]
    Grid {
        /// The grid asked for.
        grid: RasterGrid,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A vertex is not finite, or billions of pixels away.
    #[error(
        "vertex {vertex} of ring {ring} is at ({x_m}, {y_m}) m: too far from the map to be drawn"
    )]
    Vertex {
        /// Index of the ring within the building.
        ring: usize,
        /// Index of the vertex within the ring.
        vertex: usize,
        /// Position \[m\].
        x_m: f64,
        /// Position \[m\].
        y_m: f64,
    },
}

/// An image of buildings.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    grid: RasterGrid,
    pixels: Vec<u8>,
}

impl Raster {
    /// An image without buildings.
    ///
    /// # Errors
    /// [`RasterError::Grid`].
    pub fn empty(grid: RasterGrid) -> Result<Self, RasterError> {
        match grid.problem() {
            Some(problem) => Err(RasterError::Grid { grid, problem }),
            None => Ok(Raster {
                grid,
                pixels: vec![0; grid.width * grid.height],
            }),
        }
    }

    /// An image of buildings without courtyards: one ring each, open or closed, in any sense of
    /// rotation.
    ///
    /// ```
    /// use aps_data::{Raster, RasterGrid};
    /// let house = vec![[1.0, 1.0], [3.0, 1.0], [3.0, 2.0], [1.0, 2.0]];
    /// let raster = Raster::of_polygons(&[house], RasterGrid::square(5, 5.0))?;
    /// assert_eq!(raster.row(1), [0, 1, 1, 1, 0]);
    /// assert_eq!(raster.row(3), [0, 0, 0, 0, 0]);
    /// # Ok::<(), aps_data::RasterError>(())
    /// ```
    ///
    /// # Errors
    /// As [`Raster::empty`] and [`Raster::fill_building`].
    pub fn of_polygons(
        polygons_m: &[Vec<[f64; 2]>],
        grid: RasterGrid,
    ) -> Result<Self, RasterError> {
        let mut raster = Raster::empty(grid)?;
        for polygon in polygons_m {
            raster.fill_building([polygon.as_slice()])?;
        }
        Ok(raster)
    }

    /// An image from its pixels, row by row; `None` when their number does not fit the grid or one
    /// is not 0 or 1.
    pub fn from_pixels(grid: RasterGrid, pixels: Vec<u8>) -> Option<Self> {
        let fits = grid.problem().is_none() && pixels.len() == grid.width * grid.height;
        (fits && pixels.iter().all(|&pixel| pixel <= 1)).then_some(Raster { grid, pixels })
    }

    /// Whether a point \[m\] has nothing but set pixels around it: all those at most
    /// [`Raster::DEPTH`] rows and columns from the nearest one.
    ///
    /// A set pixel alone does not tell inside from beside: it touches a building. So this finds
    /// points in a building, but not those near its walls.
    pub fn is_deep_inside(&self, point_m: [f64; 2]) -> bool {
        let [x, y] = point_m.map(|v| (v / self.grid.metres_per_pixel).round());
        let side = |centre: f64, size: usize| {
            let (first, last) = (centre - Self::DEPTH as f64, centre + Self::DEPTH as f64);
            let fits = first >= 0.0 && last < size as f64;
            fits.then(|| first as usize..last as usize + 1)
        };
        let (Some(columns), Some(mut rows)) = (side(x, self.grid.width), side(y, self.grid.height))
        else {
            return false;
        };
        rows.all(|y| self.row(y)[columns.clone()].iter().all(|&pixel| pixel == 1))
    }

    /// Rows and columns that [`Raster::is_deep_inside`] looks at on each side. On the paper's 51 maps 1 takes 16 of the
    /// 2,136,261 outdoor points of the metre grid for indoor ones, 2 takes 2 of them, 3 none.
    pub const DEPTH: usize = 4;

    /// Adds one building: an outer ring, and further rings for its courtyards \[m\].
    ///
    /// Cost: edges times rows of the building.
    ///
    /// # Errors
    /// [`RasterError::Vertex`]; the image is then as before.
    pub fn fill_building<'a>(
        &mut self,
        rings_m: impl IntoIterator<Item = &'a [[f64; 2]]>,
    ) -> Result<(), RasterError> {
        let mut edges = Vec::new();
        for (ring, vertices_m) in rings_m.into_iter().enumerate() {
            let vertices = self.in_steps(ring, vertices_m)?;
            let following = vertices.iter().cycle().skip(1);
            edges.extend(
                vertices
                    .iter()
                    .zip(following)
                    .map(|(&a, &b)| Edge::between(a, b)),
            );
        }
        let Some(top) = edges.iter().map(|edge| edge.low[1]).min() else {
            return Ok(());
        };
        let bottom = edges.iter().map(|edge| edge.high[1]).max().unwrap_or(top);
        let first = top.div_euclid(STEPS).max(0);
        let last = bottom.div_euclid(STEPS).min(self.grid.height as i128 - 1);
        for row in first..=last {
            self.fill_row(row, &edges);
        }
        Ok(())
    }

    fn in_steps(
        &self,
        ring: usize,
        vertices_m: &[[f64; 2]],
    ) -> Result<Vec<[i128; 2]>, RasterError> {
        let to_steps = |metres: f64| {
            let steps = (metres / self.grid.metres_per_pixel * STEPS as f64).round();
            (steps.abs() < MAX_STEPS).then_some(steps as i128)
        };
        let vertices = vertices_m.iter().enumerate();
        vertices
            .map(
                |(vertex, &[x_m, y_m])| match (to_steps(x_m), to_steps(y_m)) {
                    (Some(x), Some(y)) => Ok([x, y]),
                    _ => Err(RasterError::Vertex {
                        ring,
                        vertex,
                        x_m,
                        y_m,
                    }),
                },
            )
            .collect()
    }

    fn fill_row(&mut self, row: i128, edges: &[Edge]) {
        let y = row * STEPS;
        // First and last pixel at each crossing of the row with a wall. Both grow with the crossing's x, so
        // that sorting them apart pairs them as sorting the crossings would.
        let (mut firsts, mut lasts) = (Vec::new(), Vec::new());
        for edge in edges
            .iter()
            .filter(|edge| (edge.low[1]..=edge.high[1]).contains(&y))
        {
            let (first, last) = edge.pixels_at(y);
            self.set(row, first, last);
            // Half open, so that a wall's end shared with the next wall counts once.
            if y < edge.high[1] {
                let (first, last) = edge.crossing_pixels_at(y);
                firsts.push(first);
                lasts.push(last);
            }
        }
        firsts.sort_unstable();
        lasts.sort_unstable();
        let entries = firsts.iter().step_by(2);
        let exits = lasts.iter().skip(1).step_by(2);
        for (&first, &last) in entries.zip(exits) {
            self.set(row, first, last);
        }
    }

    fn set(&mut self, row: i128, first: i128, last: i128) {
        let first = first.max(0);
        let last = last.min(self.grid.width as i128 - 1);
        if first <= last {
            let start = row as usize * self.grid.width;
            self.pixels[start + first as usize..=start + last as usize].fill(1);
        }
    }

    /// The pixels of the image.
    pub fn grid(&self) -> RasterGrid {
        self.grid
    }

    /// All pixels, row by row: 1 for a building, 0 for open ground.
    pub fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// The pixels of row `y`.
    ///
    /// # Panics
    /// When `y` is not below the grid's height.
    pub fn row(&self, y: usize) -> &[u8] {
        &self.pixels[y * self.grid.width..][..self.grid.width]
    }
}

/// A wall, with its ends ordered by `y` \[steps\].
struct Edge {
    low: [i128; 2],
    high: [i128; 2],
}

impl Edge {
    fn between(a: [i128; 2], b: [i128; 2]) -> Self {
        if a[1] <= b[1] {
            Edge { low: a, high: b }
        } else {
            Edge { low: b, high: a }
        }
    }

    /// First and last pixel the wall touches in the row at `y`, which it reaches.
    fn pixels_at(&self, y: i128) -> (i128, i128) {
        if self.low[1] == self.high[1] {
            let (left, right) = (self.low[0].min(self.high[0]), self.low[0].max(self.high[0]));
            (first_pixel(left, 1), last_pixel(right, 1))
        } else {
            self.crossing_pixels_at(y)
        }
    }

    /// First and last pixel touched by the point where the wall, not horizontal, crosses the row at
    /// `y`.
    fn crossing_pixels_at(&self, y: i128) -> (i128, i128) {
        let rise = self.high[1] - self.low[1];
        let x_times_rise = self.low[0] * rise + (y - self.low[1]) * (self.high[0] - self.low[0]);
        (
            first_pixel(x_times_rise, rise),
            last_pixel(x_times_rise, rise),
        )
    }
}

/// The first pixel whose open segment reaches beyond `x = numerator / denominator` \[steps\].
fn first_pixel(numerator: i128, denominator: i128) -> i128 {
    (numerator - STEPS / 2 * denominator).div_euclid(STEPS * denominator) + 1
}

/// The last pixel whose open segment begins before `x = numerator / denominator` \[steps\].
fn last_pixel(numerator: i128, denominator: i128) -> i128 {
    -(-numerator - STEPS / 2 * denominator).div_euclid(STEPS * denominator) - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draw(side: usize, rings: &[&[[f64; 2]]]) -> Vec<String> {
        let mut raster = Raster::empty(RasterGrid::square(side, side as f64)).unwrap();
        raster.fill_building(rings.iter().copied()).unwrap();
        let row = |y| {
            raster
                .row(y)
                .iter()
                .map(|&pixel| if pixel == 1 { '#' } else { '.' })
                .collect()
        };
        (0..side).map(row).collect()
    }

    #[test]
    fn walls_belong_to_the_building() {
        let square = [[1.0, 1.0], [3.0, 1.0], [3.0, 3.0], [1.0, 3.0], [1.0, 1.0]];
        assert_eq!(
            draw(5, &[&square]),
            [".....", ".###.", ".###.", ".###.", "....."]
        );
    }

    #[test]
    fn courtyard_stays_open_inside_its_walls() {
        let outer = [[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [0.0, 6.0]];
        let inner = [[2.0, 2.0], [4.0, 2.0], [4.0, 4.0], [2.0, 4.0]];
        assert_eq!(draw(7, &[&outer, &inner])[3], "###.###");
    }

    #[test]
    fn building_across_the_border_is_cut() {
        let square = [[-5.0, -5.0], [1.0, -5.0], [1.0, 9.0], [-5.0, 9.0]];
        assert_eq!(draw(3, &[&square]), ["##.", "##.", "##."]);
    }

    #[test]
    fn slanted_wall_takes_every_pixel_it_crosses_in_a_row() {
        let sliver = [[0.0, 0.0], [6.0, 2.0], [6.0, 2.0]];
        assert_eq!(draw(7, &[&sliver])[1], "...#...");
    }

    #[test]
    fn wall_halfway_between_two_pixels_touches_neither() {
        let wall = [[1.5, 0.0], [1.5, 2.0]];
        assert_eq!(draw(3, &[&wall]), ["...", "...", "..."]);
    }

    #[test]
    fn empty_ring_draws_nothing() {
        assert_eq!(draw(2, &[&[]]), ["..", ".."]);
    }

    #[test]
    fn pixel_size_scales_the_map() {
        let house = vec![[10.0, 10.0], [30.0, 10.0], [30.0, 20.0], [10.0, 20.0]];
        let small = Raster::of_polygons(&[house], RasterGrid::square(5, 50.0)).unwrap();
        assert_eq!(small.row(1), [0, 1, 1, 1, 0]);
    }

    #[test]
    fn vertex_that_is_no_point_is_named() {
        let bad = vec![[0.0, 0.0], [f64::NAN, 1.0]];
        let error = Raster::of_polygons(&[bad], RasterGrid::default()).unwrap_err();
        assert!(
            matches!(
                error,
                RasterError::Vertex {
                    ring: 0,
                    vertex: 1,
                    ..
                }
            ),
            "{error}"
        );
    }
}
