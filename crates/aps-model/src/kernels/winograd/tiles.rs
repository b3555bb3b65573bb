//! Division of images into tiles, and of tiles into chunks that stay in cache.

use std::ops::Range;

use crate::kernels::ConvShape;

/// Tiles or channels worked on at once.
pub(super) const LANES: usize = 16;

/// Most transformed values, of inputs and outputs together, at once: 4 MB, the second-level caches of two cores.
const CHUNK_VALUES: usize = 1 << 20;

/// Outputs along a side of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::kernels) enum Size {
    Two,
    Four,
}

/// The tiles of M x M outputs of every image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tiles<const M: usize> {
    pub shape: ConvShape,
    /// Tiles in a row.
    pub across: usize,
    /// Rows of tiles.
    pub down: usize,
    /// Values from one row of transformed values, which has a value a tile of a chunk, to the next: never without a gap, so
    /// that whole vectors may reach beyond the last tile and rows do not fall on the same cache lines.
    pub stride: usize,
    images_a_chunk: usize,
    rows_a_chunk: usize,
}

/// Tiles worked on at once: of whole images, or some rows of tiles of one image.
#[derive(Debug, Clone)]
pub(super) struct Chunk {
    pub images: Range<usize>,
    pub rows: Range<usize>,
}

impl<const M: usize> Tiles<M> {
    pub fn of(shape: &ConvShape) -> Self {
        let (height, width) = (shape.out_height(), shape.out_width());
        let (down, across) = (height.div_ceil(M), width.div_ceil(M));
        let values = (M + 2) * (M + 2);
        let most = CHUNK_VALUES / (values * (shape.in_channels + shape.out_channels));
        // Equal chunks rather than a small last one.
        let evenly = |all: usize, most: usize| all.div_ceil(all.div_ceil(most.max(1)));
        let images_a_chunk = evenly(shape.batch, most / (down * across));
        let rows_a_chunk = match images_a_chunk {
            1 => evenly(down, most / across),
            _ => down,
        };
        Self {
            shape: *shape,
            across,
            down,
            stride: images_a_chunk * rows_a_chunk * across + LANES,
            images_a_chunk,
            rows_a_chunk,
        }
    }

    pub fn chunks(self) -> impl Iterator<Item = Chunk> {
        let images = (0..self.shape.batch).step_by(self.images_a_chunk);
        images.flat_map(move |n| {
            let images = n..self.shape.batch.min(n + self.images_a_chunk);
            let rows = (0..self.down).step_by(self.rows_a_chunk);
            rows.map(move |row| Chunk {
                images: images.clone(),
                rows: row..self.down.min(row + self.rows_a_chunk),
            })
        })
    }

    /// Tiles of a chunk.
    pub fn count(&self, chunk: &Chunk) -> usize {
        chunk.images.len() * chunk.rows.len() * self.across
    }
}
