//! 3 x 3 convolutions with stride 1 by minimal filtering: 16 products where four outputs have 36 (Lavin and Gray, "Fast
//! Algorithms for Convolutional Neural Networks", CVPR 2016).
//!
//! Inputs and kernels are transformed, each of the 16 values of a tile is a matrix product over the channels, and products
//! are transformed back. All factors are 1 and 1/2, so that rounding grows little: the tests hold it to the bound of the
//! plain way.

mod tiles;
mod transform;

use rayon::prelude::*;

use self::tiles::{Chunk, Tiles};
use self::transform::{Plane, VALUES};
use super::ConvShape;
use super::buffer::Buffer;
use super::matmul::{Matrix, multiply};

/// Fewest channels, on both sides, that repay the transforms.
const CHANNELS: usize = 16;
/// Fewest tiles in all that repay the larger kernels.
const TILES: usize = 48;
/// Output channels of one matrix product.
const CHANNEL_BLOCK: usize = 128;
/// Values between the transformed kernels of two output channels.
const GAP: usize = 16;

/// Whether a convolution can be done this way and gains by it.
pub(super) fn suits(shape: &ConvShape) -> bool {
    let (height, width) = (shape.out_height(), shape.out_width());
    let tiles = shape.batch * height.div_ceil(2) * width.div_ceil(2);
    shape.kernel == (3, 3)
        && shape.stride == 1
        && shape.padding.0 <= 2
        && shape.padding.1 <= 2
        && shape.in_channels.min(shape.out_channels) >= CHANNELS
        && height.min(width) >= 3
        && tiles >= TILES
}

/// As [`convolve`](super::convolution::convolve).
pub(super) fn convolve(
    shape: &ConvShape,
    x: &[f32],
    weight: &[f32],
    bias: Option<&[f32]>,
    out: &mut [f32],
) {
    let tiles = Tiles::of(shape);
    let (inputs, outputs) = (shape.in_channels, shape.out_channels);
    let (pixels, stride) = (shape.out_pixels(), tiles.stride);
    let plane = output_plane(&tiles);

    let kernel_stride = VALUES * inputs + GAP;
    let mut kernels = Buffer::of(outputs * kernel_stride);
    kernels
        .par_chunks_mut(kernel_stride)
        .zip(weight.par_chunks(9 * inputs))
        .with_min_len(4)
        .for_each_init(Vec::new, |taps, (out, w)| transform::kernels(w, out, taps));

    let mut transformed = Buffer::of(inputs * VALUES * stride);
    let mut products = Buffer::of(VALUES * outputs * stride);
    for chunk in tiles.chunks() {
        let count = tiles.count(&chunk);
        transform_inputs(&tiles, &chunk, x, &mut transformed);
        let blocks = outputs.div_ceil(CHANNEL_BLOCK);
        let tasks = in_blocks(&mut products, outputs * stride, CHANNEL_BLOCK * stride);
        tasks.into_par_iter().enumerate().for_each(|(i, products)| {
            let (value, first) = (i / blocks, i % blocks * CHANNEL_BLOCK);
            let a = Matrix {
                data: &transformed[value * stride..],
                row_stride: 1,
                col_stride: VALUES * stride,
            };
            let b = Matrix {
                data: &kernels[first * kernel_stride + value * inputs..],
                row_stride: 1,
                col_stride: kernel_stride,
            };
            let sizes = (count, products.len() / stride, inputs);
            multiply(sizes, a, b, products, stride, false);
        });
        let images = chunk.images.clone();
        out[images.start * outputs * pixels..images.end * outputs * pixels]
            .par_chunks_mut(pixels)
            .with_min_len(4)
            .enumerate()
            .for_each_init(Vec::new, |lines, (i, out)| {
                let (image, channel) = (i / outputs, i % outputs);
                let bias = bias.map_or(0.0, |b| b[channel]);
                let first = image * chunk.rows.len() * tiles.across;
                let products = &products[channel * stride + first..];
                let rows = chunk.rows.clone();
                transform::outputs(products, outputs * stride, bias, out, plane, rows, lines);
            });
    }
}

/// As [`weight_gradient`](super::weight_gradient()).
pub(super) fn weight_gradient(shape: &ConvShape, x: &[f32], grad: &[f32], out: &mut [f32]) {
    let tiles = Tiles::of(shape);
    let (inputs, outputs, stride) = (shape.in_channels, shape.out_channels, tiles.stride);
    let mut transformed = Buffer::of(inputs * VALUES * stride);
    let mut gradients = Buffer::of(outputs * VALUES * stride);
    let mut sums = Buffer::of(VALUES * outputs * inputs);
    for (n, chunk) in tiles.chunks().enumerate() {
        let count = tiles.count(&chunk);
        transform_inputs(&tiles, &chunk, x, &mut transformed);
        let work = transform::output_gradients;
        transform_planes(
            &tiles,
            &chunk,
            grad,
            output_plane(&tiles),
            &mut gradients,
            work,
        );
        let blocks = outputs.div_ceil(CHANNEL_BLOCK);
        let tasks = in_blocks(&mut sums, outputs * inputs, CHANNEL_BLOCK * inputs);
        tasks.into_par_iter().enumerate().for_each(|(i, sums)| {
            let (value, first) = (i / blocks, i % blocks * CHANNEL_BLOCK);
            let a = Matrix {
                data: &transformed[value * stride..],
                row_stride: VALUES * stride,
                col_stride: 1,
            };
            let b = Matrix {
                data: &gradients[(first * VALUES + value) * stride..],
                row_stride: 1,
                col_stride: VALUES * stride,
            };
            let sizes = (inputs, sums.len() / inputs, count);
            multiply(sizes, a, b, sums, inputs, n > 0);
        });
    }
    out.par_chunks_mut(9 * inputs)
        .with_min_len(4)
        .enumerate()
        .for_each_init(Vec::new, |taps, (o, out)| {
            transform::kernel_gradients(&sums[o * inputs..], outputs * inputs, out, taps);
        });
}

/// Transformed inputs of a chunk, (channel, value, tile).
fn transform_inputs(tiles: &Tiles, chunk: &Chunk, x: &[f32], out: &mut [f32]) {
    let s = &tiles.shape;
    let plane = Plane {
        height: s.height,
        width: s.width,
        padding: s.padding,
        across: tiles.across,
    };
    transform_planes(tiles, chunk, x, plane, out, transform::inputs);
}

type PlaneTransform = fn(&[f32], Plane, std::ops::Range<usize>, &mut [f32], usize, &mut Vec<f32>);

/// `work` on every plane of (batch, channel, height, width), into (channel, value, tile).
fn transform_planes(
    tiles: &Tiles,
    chunk: &Chunk,
    x: &[f32],
    plane: Plane,
    out: &mut [f32],
    work: PlaneTransform,
) {
    let (pixels, stride) = (plane.height * plane.width, tiles.stride);
    let channels = out.len() / (VALUES * stride);
    out.par_chunks_mut(VALUES * stride)
        .with_min_len(4)
        .enumerate()
        .for_each_init(Vec::new, |lines, (channel, out)| {
            for (i, image) in chunk.images.clone().enumerate() {
                let image = &x[(image * channels + channel) * pixels..][..pixels];
                let first = i * chunk.rows.len() * tiles.across;
                let rows = chunk.rows.clone();
                work(image, plane, rows, &mut out[first..], stride, lines);
            }
        });
}

fn output_plane(tiles: &Tiles) -> Plane {
    Plane {
        height: tiles.shape.out_height(),
        width: tiles.shape.out_width(),
        padding: (0, 0),
        across: tiles.across,
    }
}

/// `data` cut into parts of `part` values, and each of them into blocks of `block`; the last of a part may be smaller.
fn in_blocks(data: &mut [f32], part: usize, block: usize) -> Vec<&mut [f32]> {
    data.chunks_mut(part)
        .flat_map(|part| part.chunks_mut(block))
        .collect()
}
