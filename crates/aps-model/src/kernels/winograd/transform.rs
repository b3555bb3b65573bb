//! The two-dimensional transforms, each over many tiles or many channels side by side.
//!
//! An input tile d (N x N, overlapping its neighbours by two) becomes B' d B, a kernel g becomes G g G', and their product,
//! value by value and summed over channels, becomes the outputs A' m A (M x M). Gradients go the transposed way.
//!
//! Tiles of a chunk are counted row of tiles by row of tiles, in it image by image, in it column by column: so a tile and
//! the one below it are the same distance apart all over the chunk. Pixels are first sorted by their place in the tile;
//! then all transforms work on [`LANES`] neighbouring tiles at once. What lies behind the last tile of a row of values is
//! worked on with the rest and read by nobody.
//!
//! Widths that occur in the models are known to the compiler (`W` tiles across; 0 is any other), so that short rows move in
//! registers.

use multiversion::multiversion;

use super::filter::Filter;
use super::tiles::{Chunk, LANES, Tiles};

type Lanes = [f32; LANES];

/// The planes of one channel in a batch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Planes<'a> {
    /// Values from the channel's plane in the first image on.
    pub data: &'a [f32],
    /// Values from one image to the next.
    pub apart: usize,
    pub height: usize,
    pub width: usize,
    /// Zeros above and left of the plane; as many as needed lie below and right.
    pub padding: (usize, usize),
}

/// `$call` with the width of tile rows as the constant `$w` where it is among the usual ones.
macro_rules! by_width {
    ($width:expr, $w:ident => $call:expr) => {
        by_width!($width, $w => $call, 1 2 4 8 16 32)
    };
    ($width:expr, $w:ident => $call:expr, $($usual:literal)*) => {
        match $width {
            $($usual => {
                const $w: usize = $usual;
                $call
            })*
            _ => {
                const $w: usize = 0;
                $call
            }
        }
    };
}

/// `f` both ways over a chunk's tiles of L x L pixels: value f of tile t at `out[f * stride + t]`. `sorted` is working memory.
pub(super) fn forward<const M: usize, const N: usize, const L: usize>(
    f: impl Fn([f32; L]) -> [f32; N],
    planes: Planes<'_>,
    tiles: &Tiles<M>,
    chunk: &Chunk,
    out: &mut [f32],
    sorted: &mut Vec<f32>,
) {
    by_width!(tiles.across, W => {
        transformed::<_, M, N, L, W>(f, planes, tiles, chunk, out, sorted);
    });
}

/// A' m A of a chunk's tiles, into the plane of each of its images: value f of tile t is `products[f * apart + t]`.
pub(super) fn outputs<F: Filter<M, N>, const M: usize, const N: usize>(
    products: &[f32],
    apart: usize,
    tiles: &Tiles<M>,
    chunk: &Chunk,
    planes: &mut [&mut [f32]],
    sorted: &mut Vec<f32>,
) {
    by_width!(tiles.across, W => {
        outputs_of::<F, M, N, W>(products, apart, tiles, chunk, planes, sorted);
    });
}

/// `f` both ways over tiles of L x L pixels, which begin M pixels apart: they overlap where L is more.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn transformed<G, const M: usize, const N: usize, const L: usize, const W: usize>(
    f: G,
    planes: Planes<'_>,
    tiles: &Tiles<M>,
    chunk: &Chunk,
    out: &mut [f32],
    sorted: &mut Vec<f32>,
) where
    G: Fn([f32; L]) -> [f32; N],
{
    let n = if W == 0 { tiles.across } else { W };
    let images = chunk.images.len();
    let (row, count) = (images * n, tiles.count(chunk));
    let overlap = L - M;
    // Pixel (k, l) of each tile at (k L + l) * apart. Where tiles overlap, of those one row beyond the chunk as well, whose
    // first rows of pixels are the last of the tiles above.
    let apart = count + row + LANES;
    sorted.resize(M * L * apart + M * n + L, 0.0);
    let (padded, sorted) = sorted.split_at_mut(M * n + L);
    padded.fill(0.0);
    let left = planes.padding.1;
    let seen = planes.width.min(M * n + overlap - left);
    for (i, tile_row) in (chunk.rows.start..chunk.rows.end + 1).enumerate() {
        let is_beyond = i == chunk.rows.len();
        for k in 0..if is_beyond { overlap } else { M } {
            let y = (M * tile_row + k).checked_sub(planes.padding.0);
            let y = y.filter(|&y| y < planes.height);
            for (image, number) in chunk.images.clone().enumerate() {
                let place = i * row + image * n;
                let target = |l: usize| (k * L + l) * apart + place;
                let Some(y) = y else {
                    for l in 0..L {
                        sorted[target(l)..][..n].fill(0.0);
                    }
                    continue;
                };
                let pixels = &planes.data[number * planes.apart + y * planes.width..];
                copy(&mut padded[left..], pixels, seen, M * n);
                let p = &padded[..M * n + L];
                for l in 0..L {
                    let target = &mut sorted[target(l)..][..n];
                    for (j, target) in target.iter_mut().enumerate() {
                        *target = p[M * j + l];
                    }
                }
            }
        }
    }
    for first in (0..count).step_by(LANES) {
        let pixel = |k: usize, l: usize| {
            let place = (k % M * L + l) * apart + k / M * row + first;
            lanes(sorted, place)
        };
        for (value, &values) in both_ways(&f, pixel).as_flattened().iter().enumerate() {
            store(out, value * tiles.stride + first, values);
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn outputs_of<F: Filter<M, N>, const M: usize, const N: usize, const W: usize>(
    products: &[f32],
    product_stride: usize,
    tiles: &Tiles<M>,
    chunk: &Chunk,
    planes: &mut [&mut [f32]],
    sorted: &mut Vec<f32>,
) {
    let n = if W == 0 { tiles.across } else { W };
    let (height, width) = (tiles.shape.out_height(), tiles.shape.out_width());
    let (row, count) = (chunk.images.len() * n, tiles.count(chunk));
    let apart = count + LANES;
    sorted.resize(M * M * apart + M * n, 0.0);
    let (line, sorted) = sorted.split_at_mut(M * n);
    for first in (0..count).step_by(LANES) {
        let value = |a: usize, b: usize| lanes(products, (N * a + b) * product_stride + first);
        let pixels = both_ways(F::output, value);
        for (pixel, &values) in pixels.as_flattened().iter().enumerate() {
            store(sorted, pixel * apart + first, values);
        }
    }
    for (i, tile_row) in chunk.rows.clone().enumerate() {
        for (image, plane) in planes.iter_mut().enumerate() {
            let place = i * row + image * n;
            for k in 0..M.min(height - M * tile_row) {
                let line = &mut line[..M * n];
                for l in 0..M {
                    let source = &sorted[(M * k + l) * apart + place..][..n];
                    for (j, &source) in source.iter().enumerate() {
                        line[M * j + l] = source;
                    }
                }
                copy(&mut plane[(M * tile_row + k) * width..], line, width, M * n);
            }
        }
    }
}

/// G g G' of kernels (channels, 3, 3): value f of channel c at `out[f * channels + c]`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
pub(super) fn kernels<F: Filter<M, N>, const M: usize, const N: usize>(
    weights: &[f32],
    out: &mut [f32],
) {
    let n = weights.len() / 9;
    let mut taps = [[0.0; LANES]; 9];
    for first in (0..n).step_by(LANES) {
        let here = LANES.min(n - first);
        let weights = weights[9 * first..].as_chunks::<9>().0;
        for (c, weights) in weights.iter().take(here).enumerate() {
            for (tap, &w) in taps.iter_mut().zip(weights) {
                tap[c] = w;
            }
        }
        let values = both_ways(F::kernel, |k, l| taps[3 * k + l]);
        for (f, values) in values.as_flattened().iter().enumerate() {
            copy(&mut out[f * n + first..], values, here, LANES);
        }
    }
}

/// G' u G, the backward pass: kernels (channels, 3, 3) from value f of channel c at `values[f * apart + c]`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
pub(super) fn kernel_gradients<F: Filter<M, N>, const M: usize, const N: usize>(
    values: &[f32],
    apart: usize,
    out: &mut [f32],
) {
    let n = out.len() / 9;
    for first in (0..n).step_by(LANES) {
        let here = LANES.min(n - first);
        let value = |a: usize, b: usize| {
            let mut lanes = [0.0; LANES];
            let values = &values[(N * a + b) * apart + first..];
            copy(&mut lanes, values, here, LANES);
            lanes
        };
        let taps = both_ways(F::kernel_gradient, value);
        let out = out[9 * first..].as_chunks_mut::<9>().0;
        for (c, out) in out.iter_mut().take(here).enumerate() {
            for (out, tap) in out.iter_mut().zip(taps.as_flattened()) {
                *out = tap[c];
            }
        }
    }
}

/// `f` down every column and then along every row of A x A values, which `value` gives by row and column.
#[inline(always)]
fn both_ways<const A: usize, const B: usize>(
    f: impl Fn([f32; A]) -> [f32; B],
    value: impl Fn(usize, usize) -> Lanes,
) -> [[Lanes; B]; B] {
    let mut columns = [[[0.0; LANES]; B]; A];
    for (l, column) in columns.iter_mut().enumerate() {
        let mut line = [[0.0; LANES]; A];
        for (k, pixel) in line.iter_mut().enumerate() {
            *pixel = value(k, l);
        }
        *column = map(&f, &line);
    }
    let mut out = [[[0.0; LANES]; B]; B];
    for (a, out) in out.iter_mut().enumerate() {
        let mut line = [[0.0; LANES]; A];
        for (pixel, column) in line.iter_mut().zip(&columns) {
            *pixel = column[a];
        }
        *out = map(&f, &line);
    }
    out
}

/// `f` of each lane.
#[inline(always)]
fn map<const A: usize, const B: usize>(
    f: impl Fn([f32; A]) -> [f32; B],
    values: &[Lanes; A],
) -> [Lanes; B] {
    let mut out = [[0.0; LANES]; B];
    for lane in 0..LANES {
        let mut from = [0.0; A];
        for (from, values) in from.iter_mut().zip(values) {
            *from = values[lane];
        }
        for (out, made) in out.iter_mut().zip(f(from)) {
            out[lane] = made;
        }
    }
    out
}

/// The first `count` values; `usual` of them, which the compiler may know, without a call.
#[inline(always)]
fn copy(to: &mut [f32], from: &[f32], count: usize, usual: usize) {
    if count == usual {
        to[..usual].copy_from_slice(&from[..usual]);
    } else {
        to[..count].copy_from_slice(&from[..count]);
    }
}

#[inline(always)]
fn lanes(values: &[f32], place: usize) -> Lanes {
    *values[place..].first_chunk().expect("rows end with a gap")
}

#[inline(always)]
fn store(values: &mut [f32], place: usize, lanes: Lanes) {
    let target = values[place..].first_chunk_mut();
    *target.expect("rows end with a gap") = lanes;
}
