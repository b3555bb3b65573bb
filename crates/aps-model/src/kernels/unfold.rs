//! Unfolding (im2col): a convolution as a matrix product.
//!
//! An image is first written into a frame of zeros as wide as the padding, its columns sorted by their remainder modulo
//! the horizontal stride. In such a frame every row of every tap is one run of neighbouring values: unfolding is copying alone.

use std::ops::Range;

use super::ConvShape;

/// Memory layout of a padded image: (channel, row, remainder of the column, column).
#[derive(Debug, Clone)]
pub(super) struct Frame {
    shape: ConvShape,
    /// Columns of one remainder.
    phase: usize,
    row: usize,
    plane: usize,
    /// Position of the first output pixel of each tap.
    taps: Vec<usize>,
}

impl Frame {
    pub fn of(shape: &ConvShape) -> Self {
        let (step, (kh, kw)) = (shape.steps.stride.1, shape.kernel);
        let phase = (shape.width + 2 * shape.steps.padding.1).div_ceil(step);
        let row = phase * step;
        let plane = row * (shape.height + 2 * shape.steps.padding.0);
        let place = |tap: usize| {
            let (channel, ky, kx) = (tap / (kh * kw), tap / kw % kh, tap % kw);
            channel * plane + ky * row + (kx % step) * phase + kx / step
        };
        Self {
            shape: *shape,
            phase,
            row,
            plane,
            taps: (0..shape.taps()).map(place).collect(),
        }
    }

    /// Values of one framed image.
    pub fn len(&self) -> usize {
        self.plane * self.shape.in_channels
    }

    /// Writes `image` (channels, height, width) into `frame`, whose padding by zeros must be, and stays, zero.
    pub fn fill(&self, image: &[f32], frame: &mut [f32]) {
        let s = &self.shape;
        let planes = frame.chunks_exact_mut(self.plane);
        for (plane, image) in planes.zip(image.chunks_exact(s.in_pixels())) {
            let rows = plane.chunks_exact_mut(self.row).skip(s.steps.padding.0);
            for (row, pixels) in rows.zip(image.chunks_exact(s.width)) {
                self.fill_row(pixels, row);
            }
        }
    }

    /// Place of a padded column in a row.
    fn place(&self, column: usize) -> usize {
        let step = self.shape.steps.stride.1;
        column % step * self.phase + column / step
    }

    /// Columns of circular padding, each with the pixel of the row that it repeats.
    fn margins(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (width, pad) = (self.shape.width, self.shape.steps.padding.1);
        let count = if self.shape.steps.is_circular { pad } else { 0 };
        let left = (0..count).map(move |i| (i, width - pad + i));
        left.chain((0..count).map(move |i| (pad + width + i, i)))
    }

    fn fill_row(&self, pixels: &[f32], row: &mut [f32]) {
        let (step, pad) = (self.shape.steps.stride.1, self.shape.steps.padding.1);
        for (column, pixel) in self.margins() {
            row[self.place(column)] = pixels[pixel];
        }
        if step == 1 {
            row[pad..pad + pixels.len()].copy_from_slice(pixels);
            return;
        }
        for (remainder, phase) in row.chunks_exact_mut(self.phase).enumerate() {
            // The first pixel whose padded column has this remainder.
            let first = (remainder + step - pad % step) % step;
            let targets = &mut phase[(first + pad) / step..];
            let pixels = &pixels[first.min(pixels.len())..];
            match step {
                2 => every::<2>(pixels, targets),
                _ => {
                    for (t, p) in targets.iter_mut().zip(pixels.iter().step_by(step)) {
                        *t = *p;
                    }
                }
            }
        }
    }

    /// Adds up what lies in `frame` at the places of each pixel into `image`, the adjoint of [`Frame::fill`].
    pub fn extract(&self, frame: &[f32], image: &mut [f32]) {
        let s = &self.shape;
        let planes = frame.chunks_exact(self.plane);
        for (plane, image) in planes.zip(image.chunks_exact_mut(s.in_pixels())) {
            let rows = plane.chunks_exact(self.row).skip(s.steps.padding.0);
            for (row, pixels) in rows.zip(image.chunks_exact_mut(s.width)) {
                for (x, pixel) in pixels.iter_mut().enumerate() {
                    *pixel = row[self.place(x + s.steps.padding.1)];
                }
                for (column, pixel) in self.margins() {
                    pixels[pixel] += row[self.place(column)];
                }
            }
        }
    }

    /// Writes rows `taps` of some unfolded `frames` side by side, columns `pixels` (counted image by image, row by row). Row
    /// `t` of the result starts at `(t - taps.start) * stride` of `out`.
    ///
    /// Row (channel, ky, kx), column (image, oy, ox) holds padded pixel (oy * stride + ky, ox * stride + kx).
    pub fn unfold(
        &self,
        frames: &[f32],
        taps: Range<usize>,
        pixels: Range<usize>,
        out: &mut [f32],
        stride: usize,
    ) {
        let (width, all) = (self.shape.out_width(), self.shape.out_pixels());
        let lines = out.chunks_mut(stride).map(|line| &mut line[..pixels.len()]);
        let lines = lines.zip(&self.taps[taps]);
        if pixels.start.is_multiple_of(all) && pixels.len().is_multiple_of(all) {
            let frames = &frames[pixels.start / all * self.len()..];
            for (line, &tap) in lines {
                match width {
                    2 => self.copy_images::<2>(frames, tap, line),
                    4 => self.copy_images::<4>(frames, tap, line),
                    8 => self.copy_images::<8>(frames, tap, line),
                    16 => self.copy_images::<16>(frames, tap, line),
                    32 => self.copy_images::<32>(frames, tap, line),
                    _ => self.copy_runs(frames, tap, 0, line),
                }
            }
        } else {
            for (line, &tap) in lines {
                self.copy_runs(frames, tap, pixels.start, line);
            }
        }
    }

    /// Whole images with rows of `W` values: a width known to the compiler is moved in registers.
    fn copy_images<const W: usize>(&self, frames: &[f32], tap: usize, line: &mut [f32]) {
        let apart = self.shape.steps.stride.0 * self.row;
        let targets = line.chunks_exact_mut(self.shape.out_pixels());
        for (target, frame) in targets.zip(frames.chunks_exact(self.len())) {
            let rows = frame[tap..].chunks(apart);
            for (target, row) in target.as_chunks_mut::<W>().0.iter_mut().zip(rows) {
                *target = *row.first_chunk().expect("a frame holds whole rows");
            }
        }
    }

    /// Rows of any width, from pixel `first` on.
    fn copy_runs(&self, frames: &[f32], tap: usize, first: usize, line: &mut [f32]) {
        let (width, all) = (self.shape.out_width(), self.shape.out_pixels());
        let apart = self.shape.steps.stride.0 * self.row;
        let (mut at, mut rest) = (first, line);
        while !rest.is_empty() {
            let (row, column) = (at % all / width, at % width);
            let (target, behind) = rest.split_at_mut((width - column).min(rest.len()));
            let start = at / all * self.len() + tap + row * apart + column;
            target.copy_from_slice(&frames[start..][..target.len()]);
            at += target.len();
            rest = behind;
        }
    }

    /// The adjoint of unfolding whole images: adds the rows of `columns`, `stride` apart, to where they came from.
    pub fn fold(&self, columns: &[f32], stride: usize, frames: &mut [f32]) {
        for (line, &tap) in columns.chunks(stride).zip(&self.taps) {
            match self.shape.out_width() {
                2 => self.add_images::<2>(line, tap, frames),
                4 => self.add_images::<4>(line, tap, frames),
                8 => self.add_images::<8>(line, tap, frames),
                16 => self.add_images::<16>(line, tap, frames),
                _ => self.add_rows(line, tap, frames),
            }
        }
    }

    fn add_images<const W: usize>(&self, line: &[f32], tap: usize, frames: &mut [f32]) {
        let apart = self.shape.steps.stride.0 * self.row;
        let sources = line.chunks_exact(self.shape.out_pixels());
        for (source, frame) in sources.zip(frames.chunks_exact_mut(self.len())) {
            let rows = frame[tap..].chunks_mut(apart);
            for (source, row) in source.as_chunks::<W>().0.iter().zip(rows) {
                let row: &mut [f32; W] = row.first_chunk_mut().expect("a frame holds whole rows");
                for (r, s) in row.iter_mut().zip(source) {
                    *r += s;
                }
            }
        }
    }

    fn add_rows(&self, line: &[f32], tap: usize, frames: &mut [f32]) {
        let apart = self.shape.steps.stride.0 * self.row;
        let sources = line.chunks_exact(self.shape.out_pixels());
        for (source, frame) in sources.zip(frames.chunks_exact_mut(self.len())) {
            let rows = frame[tap..].chunks_mut(apart);
            for (source, row) in source.chunks_exact(self.shape.out_width()).zip(rows) {
                for (r, s) in row.iter_mut().zip(source) {
                    *r += s;
                }
            }
        }
    }
}

/// Every `STEP`th of `values`.
fn every<const STEP: usize>(values: &[f32], out: &mut [f32]) {
    let (whole, rest) = values.as_chunks::<STEP>();
    let n = whole.len().min(out.len());
    for (out, values) in out[..n].iter_mut().zip(whole) {
        *out = values[0];
    }
    if let (Some(last), Some(&value)) = (out.get_mut(n), rest.first()) {
        *last = value;
    }
}
