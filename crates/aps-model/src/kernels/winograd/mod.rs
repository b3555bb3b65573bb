//! 3 x 3 convolutions with stride 1 by minimal filtering (Lavin and Gray, "Fast Algorithms for Convolutional Neural
//! Networks", CVPR 2016): 16 products where four outputs have 36, or 36 where sixteen have 144.
//!
//! Inputs and kernels are transformed, each value of a tile is a matrix product over the channels, and products are
//! transformed back. The worst error, relative to the largest output, is 6e-7 with tiles of 2 x 2 outputs and 2e-6 with
//! 4 x 4 (256 channels of rectified noise), where the plain sum has 3e-7; the tests hold the gradients to it as well.

mod cache;
mod filter;
mod tiles;
mod transform;

use rayon::prelude::*;

pub(crate) use self::cache::KernelCache;
use self::filter::{Filter, Four, Two};
use self::tiles::{Chunk, Size, Tiles};
use self::transform::Planes;
use super::ConvShape;
use super::buffer::Buffer;
use super::epilogue::Epilogue;
use super::matmul::{Matrix, multiply};
use super::regroup::GAP;

/// Fewest channels, on both sides, that repay the transforms.
const CHANNELS: usize = 16;
/// Fewest tiles in all that repay the larger kernels, if they are made anew for each call, and if they are cached.
const TILES: usize = 48;
const TILES_IF_CACHED: usize = 32;
/// Output channels of one matrix product.
const CHANNEL_BLOCK: usize = 128;

/// Returns the tiles by which a convolution is fastest; `None` where the plain way is faster, or the only one. It depends on
/// whether transformed kernels are cached from call to call.
pub(super) fn suits(shape: &ConvShape, is_cached: bool) -> Option<Size> {
    let (fewest_tiles, fewest_pixels) = match is_cached {
        true => (TILES_IF_CACHED, 2),
        false => (TILES, 3),
    };
    let fits = shape.kernel == (3, 3)
        && shape.stride == 1
        && shape.padding.0 <= 2
        && shape.padding.1 <= 2
        && shape.in_channels.min(shape.out_channels) >= CHANNELS
        && shape.out_height().min(shape.out_width()) >= fewest_pixels;
    let tiles = |m| shape.batch * shape.out_height().div_ceil(m) * shape.out_width().div_ceil(m);
    if fits && tiles(4) >= fewest_tiles && 36 * tiles(4) < 12 * tiles(2) {
        Some(Size::Four)
    } else if fits && tiles(2) >= fewest_tiles {
        Some(Size::Two)
    } else {
        None
    }
}

/// Computes [`convolve`](super::convolution::convolve).
pub(super) fn convolve(
    size: Size,
    shape: &ConvShape,
    x: &[f32],
    weight: &[f32],
    cache: Option<&KernelCache>,
    epilogue: Epilogue<'_>,
    out: &mut [f32],
) {
    let stride = kernel_stride(size, shape);
    let kernels = |out: &mut [f32]| match size {
        Size::Two => transform_kernels::<Two, 2, 4>(weight, shape, stride, out),
        Size::Four => transform_kernels::<Four, 4, 6>(weight, shape, stride, out),
    };
    let len = shape.out_channels * stride;
    let kernels = KernelCache::get_or_make(cache, size, len, kernels);
    match size {
        Size::Two => convolve_by::<Two, 2, 4>(shape, x, &kernels, epilogue, out),
        Size::Four => convolve_by::<Four, 4, 6>(shape, x, &kernels, epilogue, out),
    }
}

/// Computes [`weight_gradient`](super::weight_gradient()).
pub(super) fn weight_gradient(
    size: Size,
    shape: &ConvShape,
    x: &[f32],
    grad: &[f32],
    out: &mut [f32],
) {
    match size {
        Size::Two => weight_gradient_by::<Two, 2, 4>(shape, x, grad, out),
        Size::Four => weight_gradient_by::<Four, 4, 6>(shape, x, grad, out),
    }
}

fn convolve_by<F: Filter<M, N>, const M: usize, const N: usize>(
    shape: &ConvShape,
    x: &[f32],
    kernels: &[f32],
    epilogue: Epilogue<'_>,
    out: &mut [f32],
) {
    let (tiles, planes) = (Tiles::<M>::of(shape), input_planes(shape, x));
    let (inputs, outputs, values) = (shape.in_channels, shape.out_channels, N * N);
    let stride = tiles.stride;
    let kernel_stride = kernels.len() / outputs;
    let mut transformed = Buffer::of(inputs * values * stride);
    let mut products = Buffer::of(values * outputs * stride);
    for chunk in tiles.chunks() {
        let count = tiles.count(&chunk);
        transform_channels(F::input, planes, &tiles, &chunk, &mut transformed);
        let factors = |value: usize, first: usize| {
            let kernels = &kernels[first * kernel_stride + value * inputs..];
            [
                Matrix::columns(&transformed[value * stride..], values * stride),
                Matrix::columns(kernels, kernel_stride),
            ]
        };
        let sizes = (count, outputs, inputs);
        multiply_values(sizes, factors, &mut products, stride, false);
        transform_outputs::<F, M, N>(&tiles, &chunk, &products, epilogue, out);
    }
}

fn weight_gradient_by<F: Filter<M, N>, const M: usize, const N: usize>(
    shape: &ConvShape,
    x: &[f32],
    grad: &[f32],
    out: &mut [f32],
) {
    let (tiles, planes) = (Tiles::<M>::of(shape), input_planes(shape, x));
    let (inputs, outputs, values) = (shape.in_channels, shape.out_channels, N * N);
    let stride = tiles.stride;
    let mut transformed = Buffer::of(inputs * values * stride);
    let mut gradients = Buffer::of(outputs * values * stride);
    let of_grad = Planes {
        data: grad,
        apart: outputs * shape.out_pixels(),
        height: shape.out_height(),
        width: shape.out_width(),
        padding: (0, 0),
    };
    let mut sums = Buffer::of(values * outputs * inputs);
    for (n, chunk) in tiles.chunks().enumerate() {
        let count = tiles.count(&chunk);
        transform_channels(F::input, planes, &tiles, &chunk, &mut transformed);
        transform_channels(F::output_gradient, of_grad, &tiles, &chunk, &mut gradients);
        let factors = |value: usize, first: usize| {
            let gradients = &gradients[(first * values + value) * stride..];
            [
                Matrix::rows(&transformed[value * stride..], values * stride),
                Matrix::columns(gradients, values * stride),
            ]
        };
        let sizes = (inputs, outputs, count);
        multiply_values(sizes, factors, &mut sums, inputs, n > 0);
    }
    out.par_chunks_mut(9 * inputs)
        .with_min_len(4)
        .enumerate()
        .for_each(|(o, out)| {
            transform::kernel_gradients::<F, M, N>(&sums[o * inputs..], outputs * inputs, out);
        });
}

/// Writes the matrix product of each value into `out`, (value, output channel, row), channels `stride` apart, on all threads.
/// `factors` gives the factors of a value, the second from an output channel on.
fn multiply_values<'a>(
    (rows, outputs, depth): (usize, usize, usize),
    factors: impl Fn(usize, usize) -> [Matrix<'a>; 2] + Sync,
    out: &mut [f32],
    stride: usize,
    accumulate: bool,
) {
    let blocks = outputs.div_ceil(CHANNEL_BLOCK);
    let values = out.chunks_mut(outputs * stride);
    // The last block of a value may be smaller.
    let tasks: Vec<_> = values
        .flat_map(|value| value.chunks_mut(CHANNEL_BLOCK * stride))
        .collect();
    tasks.into_par_iter().enumerate().for_each(|(i, out)| {
        let [a, b] = factors(i / blocks, i % blocks * CHANNEL_BLOCK);
        let sizes = (rows, out.len() / stride, depth);
        multiply(sizes, a, b, out, stride, accumulate);
    });
}

/// Values from the transformed kernels of one output channel to those of the next.
fn kernel_stride(size: Size, shape: &ConvShape) -> usize {
    let values = match size {
        Size::Two => 16,
        Size::Four => 36,
    };
    values * shape.in_channels + GAP
}

/// Transformed kernels, (output channel, value, input channel), output channels `stride` apart.
fn transform_kernels<F: Filter<M, N>, const M: usize, const N: usize>(
    weight: &[f32],
    shape: &ConvShape,
    stride: usize,
    out: &mut [f32],
) {
    out.par_chunks_mut(stride)
        .zip(weight.par_chunks(9 * shape.in_channels))
        .with_min_len(4)
        .for_each(|(out, w)| transform::kernels::<F, M, N>(w, out));
}

/// Channels of a chunk transformed by `f` both ways, (channel, value, tile). `planes` are those of the first channel.
fn transform_channels<const M: usize, const N: usize, const L: usize>(
    f: impl Fn([f32; L]) -> [f32; N] + Copy + Sync,
    planes: Planes<'_>,
    tiles: &Tiles<M>,
    chunk: &Chunk,
    out: &mut [f32],
) {
    out.par_chunks_mut(N * N * tiles.stride)
        .with_min_len(4)
        .enumerate()
        .for_each_init(Vec::new, |sorted, (channel, out)| {
            let planes = Planes {
                data: &planes.data[channel * planes.height * planes.width..],
                ..planes
            };
            transform::forward(f, planes, tiles, chunk, out, sorted);
        });
}

/// Planes of the first input channel.
fn input_planes<'a>(shape: &ConvShape, x: &'a [f32]) -> Planes<'a> {
    Planes {
        data: x,
        apart: shape.in_channels * shape.in_pixels(),
        height: shape.height,
        width: shape.width,
        padding: shape.padding,
    }
}

/// The outputs of a chunk from its products, (value, channel, tile).
fn transform_outputs<F: Filter<M, N>, const M: usize, const N: usize>(
    tiles: &Tiles<M>,
    chunk: &Chunk,
    products: &[f32],
    epilogue: Epilogue<'_>,
    out: &mut [f32],
) {
    let (channels, pixels) = (tiles.shape.out_channels, tiles.shape.out_pixels());
    let image = channels * pixels;
    let mut planes: Vec<Vec<&mut [f32]>> = Vec::new();
    planes.resize_with(channels, || Vec::with_capacity(chunk.images.len()));
    let out = &mut out[chunk.images.start * image..chunk.images.end * image];
    for (i, plane) in out.chunks_exact_mut(pixels).enumerate() {
        planes[i % channels].push(plane);
    }
    planes
        .into_par_iter()
        .with_min_len(4)
        .enumerate()
        .for_each_init(Vec::new, |sorted, (channel, mut planes)| {
            let products = &products[channel * tiles.stride..];
            let apart = channels * tiles.stride;
            transform::outputs::<F, M, N>(products, apart, tiles, chunk, &mut planes, sorted);
            let rows = M * chunk.rows.start * tiles.shape.out_width();
            for (number, plane) in chunk.images.clone().zip(planes) {
                let end = (M * chunk.rows.end * tiles.shape.out_width()).min(pixels);
                let place = (number * channels + channel) * pixels + rows;
                epilogue.apply(channel, place, &mut plane[rows..end]);
            }
        });
}
