//! The part of the plane that a condition image shows.

use candle_core::{Result, Tensor};
use serde::{Deserialize, Serialize};

use crate::named::named;

/// Frame of condition images.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// The whole map, as in the paper.
    #[default]
    Map,
    /// A window as large as the map with the receiver in its middle; open ground beyond the map. It is not turned to the
    /// transmitter: a linear array keeps its direction.
    Receiver,
}

named!(Frame, "frame": Map = "map", Receiver = "receiver");

/// Sums over maps, from which the average over any rectangle follows at once (Crow, SIGGRAPH 1984).
#[derive(Debug, Clone)]
pub(super) struct Sums {
    /// For each map, sums of all pixels above and left of each corner of pixels; (height + 1) x (width + 1).
    sums: Vec<f64>,
    width: usize,
    height: usize,
}

impl Sums {
    pub fn new(pixels: &[f32], [height, width]: [usize; 2]) -> Self {
        let mut sums = Vec::with_capacity(pixels.len() / width * (width + 2));
        for map in pixels.chunks_exact(height * width) {
            let first = sums.len();
            sums.resize(first + width + 1, 0.0);
            for row in map.chunks_exact(width) {
                let above = sums.len() - (width + 1);
                let mut along = 0.0;
                sums.push(0.0);
                for (x, &pixel) in row.iter().enumerate() {
                    along += f64::from(pixel);
                    sums.push(sums[above + x + 1] + along);
                }
            }
        }
        Self {
            sums,
            width,
            height,
        }
    }

    /// Averages over the pixels of an image of `size` x `size` that is as large as the map and has the point `middle`, in
    /// pixels from the map's corner, in its middle. O(size^2).
    pub fn average(&self, map: usize, middle: [f64; 2], size: usize, image: &mut [f32]) {
        let edges = |side: usize, middle: f64| -> Vec<(usize, f64)> {
            let step = side as f64 / size as f64;
            let first = middle - 0.5 * side as f64;
            let edge = |i: usize| {
                let at = (first + i as f64 * step).clamp(0.0, side as f64);
                let whole = (at as usize).min(side - 1);
                (whole, at - whole as f64)
            };
            (0..=size).map(edge).collect()
        };
        let (columns, rows) = (edges(self.width, middle[0]), edges(self.height, middle[1]));
        let stride = self.width + 1;
        let sums = &self.sums[map * stride * (self.height + 1)..];
        let area = (self.width * self.height) as f64 / (size * size) as f64;
        // Sums up to an edge between rows, at each edge between columns. A map's sums are bilinear within a pixel.
        let up_to = |(y, share): (usize, f64)| {
            let [upper, lower] = [y, y + 1].map(|y| &sums[y * stride..][..stride]);
            columns.iter().map(move |&(x, along)| {
                let at = |row: &[f64]| row[x] + along * (row[x + 1] - row[x]);
                at(upper) + share * (at(lower) - at(upper))
            })
        };
        let mut above: Vec<f64> = up_to(rows[0]).collect();
        let mut below = Vec::with_capacity(above.len());
        for (row, &edge) in image.chunks_exact_mut(size).zip(&rows[1..]) {
            below.clear();
            below.extend(up_to(edge));
            for (i, value) in row.iter_mut().enumerate() {
                let sum = below[i + 1] - below[i] - above[i + 1] + above[i];
                *value = ((sum / area) as f32).clamp(0.0, 1.0);
            }
            std::mem::swap(&mut above, &mut below);
        }
    }
}

/// Averages maps (links, height, width) over windows as [`Sums::average`] does, by candle's operations: a product with the shares of
/// the rows that each pixel covers, and one with those of the columns.
pub(super) fn averages(maps: &Tensor, middles: &[[f64; 2]], size: usize) -> Result<Tensor> {
    let (_, height, width) = maps.dims3()?;
    let shares = |axis: usize, side: usize| {
        let first = middles
            .iter()
            .map(|middle| (middle[axis] - 0.5 * side as f64) as f32);
        let first = Tensor::from_iter(first, maps.device())?.reshape(((), 1, 1))?;
        let row = |count: usize| Tensor::arange(0.0_f32, count as f32, maps.device());
        let step = side as f64 / size as f64;
        let from = (row(size)?.reshape((1, 1, ()))? * step)?.broadcast_add(&first)?;
        let pixel = row(side)?.reshape((1, (), 1))?;
        let end = (&from + step)?.broadcast_minimum(&(&pixel + 1.0)?)?;
        // Shares of a pixel of the image.
        (end - from.broadcast_maximum(&pixel)?)?.relu()? / step
    };
    let (columns, rows) = (shares(0, width)?, shares(1, height)?);
    rows.transpose(1, 2)?
        .contiguous()?
        .matmul(maps)?
        .matmul(&columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_about_the_middle_of_the_map_is_the_map() {
        let map: Vec<f32> = (0..2 * 8 * 12).map(|i| f32::from(i % 5 < 2)).collect();
        let sums = Sums::new(&map, [8, 12]);
        for size in [4, 8, 5] {
            let mut image = vec![0.0; size * size];
            sums.average(1, [6.0, 4.0], size, &mut image);
            let own = super::super::area::average(&map[96..], [8, 12], size);
            for (i, (a, b)) in image.iter().zip(&own).enumerate() {
                assert!((a - b).abs() < 1e-6, "{size}, pixel {i}: {a} for {b}");
            }
        }
    }

    #[test]
    fn a_shift_by_half_a_pixel_averages_neighbours_and_beyond_the_map_is_nothing() {
        let sums = Sums::new(&[1.0, 0.0, 1.0, 1.0], [2, 2]);
        let mut image = [9.0; 4];
        sums.average(0, [1.5, 1.0], 2, &mut image);
        assert_eq!(image, [0.5, 0.0, 1.0, 0.5]);
        sums.average(0, [1.0, 3.0], 2, &mut image);
        assert_eq!(image, [0.0; 4]);
    }
}
