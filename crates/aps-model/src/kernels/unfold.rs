//! Unfolding (im2col): a convolution as a matrix product.
//!
//! An image is first written into a frame of zeros as wide as the padding, its columns sorted by their remainder modulo
//! the stride. In such a frame every row of every tap is one run of neighbouring values: unfolding is copying alone.

use std::ops::Range;

use super::ConvShape;

/// How a padded image lies in memory: (channel, row, remainder of the column, column).
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    shape: ConvShape,
    /// Columns of one remainder.
    phase: usize,
    row: usize,
    plane: usize,
}

impl Frame {
    pub fn of(shape: &ConvShape) -> Self {
        let phase = (shape.width + 2 * shape.padding.1).div_ceil(shape.stride);
        let row = phase * shape.stride;
        Self {
            shape: *shape,
            phase,
            row,
            plane: row * (shape.height + 2 * shape.padding.0),
        }
    }

    /// Values of one framed image.
    pub fn len(&self) -> usize {
        self.plane * self.shape.in_channels
    }

    /// Writes `image` (channels, height, width) into `frame`, whose padding must be, and stays, zero.
    pub fn fill(&self, image: &[f32], frame: &mut [f32]) {
        let s = &self.shape;
        let planes = frame.chunks_exact_mut(self.plane);
        for (plane, image) in planes.zip(image.chunks_exact(s.in_pixels())) {
            let rows = plane.chunks_exact_mut(self.row).skip(s.padding.0);
            for (row, pixels) in rows.zip(image.chunks_exact(s.width)) {
                self.fill_row(pixels, row);
            }
        }
    }

    fn fill_row(&self, pixels: &[f32], row: &mut [f32]) {
        let (step, pad) = (self.shape.stride, self.shape.padding.1);
        if step == 1 {
            row[pad..pad + pixels.len()].copy_from_slice(pixels);
            return;
        }
        for (remainder, phase) in row.chunks_exact_mut(self.phase).enumerate() {
            // The first pixel whose padded column has this remainder.
            let first = (remainder + step - pad % step) % step;
            let targets = phase[(first + pad) / step..].iter_mut();
            for (t, p) in targets.zip(pixels[first.min(pixels.len())..].iter().step_by(step)) {
                *t = *p;
            }
        }
    }

    /// Writes rows `taps` of the unfolded image for the output pixels `pixels` (counted row by row). Row `t` of the result
    /// starts at `(t - taps.start) * stride` of `out`.
    ///
    /// Row (channel, ky, kx), column (oy, ox) holds padded pixel (oy * step + ky, ox * step + kx).
    pub fn unfold(
        &self,
        frame: &[f32],
        taps: Range<usize>,
        pixels: Range<usize>,
        out: &mut [f32],
        stride: usize,
    ) {
        let (kh, kw) = self.shape.kernel;
        let width = self.shape.out_width();
        let (first_row, first_column) = (pixels.start / width, pixels.start % width);
        let whole_rows = first_column == 0 && pixels.len().is_multiple_of(width);
        for (i, tap) in taps.enumerate() {
            let (channel, ky, kx) = (tap / (kh * kw), tap / kw % kh, tap % kw);
            let step = self.shape.stride;
            let column = (kx % step) * self.phase + kx / step;
            let start = channel * self.plane + (first_row * step + ky) * self.row + column;
            let source = &frame[start..];
            let line = &mut out[i * stride..][..pixels.len()];
            let apart = step * self.row;
            match width {
                2 if whole_rows => copy_rows::<2>(source, apart, line),
                4 if whole_rows => copy_rows::<4>(source, apart, line),
                8 if whole_rows => copy_rows::<8>(source, apart, line),
                16 if whole_rows => copy_rows::<16>(source, apart, line),
                32 if whole_rows => copy_rows::<32>(source, apart, line),
                _ => copy_runs(&source[first_column..], apart, width, first_column, line),
            }
        }
    }
}

/// Rows of `W` values, `apart` from each other: a width known to the compiler is moved in registers.
fn copy_rows<const W: usize>(source: &[f32], apart: usize, line: &mut [f32]) {
    for (target, source) in line
        .as_chunks_mut::<W>()
        .0
        .iter_mut()
        .zip(source.chunks(apart))
    {
        *target = *source.first_chunk().expect("a frame holds whole rows");
    }
}

/// Rows of any width, the first one from column `first` on; `source` starts there.
fn copy_runs(source: &[f32], apart: usize, width: usize, first: usize, line: &mut [f32]) {
    let (head, rest) = line.split_at_mut((width - first).min(line.len()));
    head.copy_from_slice(&source[..head.len()]);
    for (i, target) in rest.chunks_mut(width).enumerate() {
        target.copy_from_slice(&source[(i + 1) * apart - first..][..target.len()]);
    }
}

/// The adjoint of one row of unfolding: adds `line`, values at all output pixels of tap (ky, kx), to the pixels of the
/// unpadded `plane` they came from.
pub(super) fn fold_row(
    shape: &ConvShape,
    line: &[f32],
    (ky, kx): (usize, usize),
    plane: &mut [f32],
) {
    let inside = columns_inside(shape, kx);
    if inside.is_empty() {
        return;
    }
    for (oy, segment) in line.chunks_exact(shape.out_width()).enumerate() {
        let y = (oy * shape.stride + ky).wrapping_sub(shape.padding.0);
        if y < shape.height {
            let first = y * shape.width + inside.start * shape.stride + kx - shape.padding.1;
            let target = plane[first..].iter_mut().step_by(shape.stride);
            for (t, s) in target.zip(&segment[inside.clone()]) {
                *t += s;
            }
        }
    }
}

/// Output columns whose tap `kx` lies inside the image.
fn columns_inside(shape: &ConvShape, kx: usize) -> Range<usize> {
    let pad = shape.padding.1;
    let start = pad.saturating_sub(kx).div_ceil(shape.stride);
    // The last column with ox * stride + kx - pad <= width - 1.
    let end = (shape.width + pad)
        .checked_sub(kx + 1)
        .map_or(0, |last| last / shape.stride + 1);
    start..end.min(shape.out_width())
}
