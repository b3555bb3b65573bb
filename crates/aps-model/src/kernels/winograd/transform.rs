//! The transforms of Winograd's F(2 x 2, 3 x 3), each over many tiles or many channels side by side:
//!
//! ```text
//!        1  0 -1  0          1   0   0
//! B' =   0  1  1  0     G =  1/2 1/2 1/2    A' =  1  1  1  0
//!        0 -1  1  0          1/2 -1/2 1/2         0  1 -1 -1
//!        0  1  0 -1          0   0   1
//! ```
//!
//! An input tile d (4 x 4, overlapping its neighbours by two) becomes B' d B, a kernel g becomes G g G', and their product,
//! value by value and summed over channels, becomes the outputs A' m A (2 x 2). Gradients go the transposed way.
//!
//! Widths that occur in the models are known to the compiler (`W`; 0 is any other), so that short rows move in registers.

use std::ops::Range;

use multiversion::multiversion;

/// Values of a transformed tile.
pub(super) const VALUES: usize = 16;

/// Sizes of a plane and of its tiles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub height: usize,
    pub width: usize,
    /// Zeros above and left of the plane; as many as needed lie below and right.
    pub padding: (usize, usize),
    /// Tiles in a row.
    pub across: usize,
}

/// Calls `$function::<W>` with the width of tile rows as `W` where it is among the usual ones.
macro_rules! by_width {
    ($width:expr, $function:ident($($argument:expr),* $(,)?)) => {
        match $width {
            2 => $function::<2>($($argument),*),
            4 => $function::<4>($($argument),*),
            8 => $function::<8>($($argument),*),
            16 => $function::<16>($($argument),*),
            32 => $function::<32>($($argument),*),
            _ => $function::<0>($($argument),*),
        }
    };
}

/// B' d B of the tiles in `rows` of `image`: value f of tile t at `out[f * stride + t]`. `lines` is working memory.
pub(super) fn inputs(
    image: &[f32],
    plane: Plane,
    rows: Range<usize>,
    out: &mut [f32],
    stride: usize,
    lines: &mut Vec<f32>,
) {
    by_width!(
        plane.across,
        inputs_of(image, plane, rows, out, stride, lines)
    );
}

/// A y A' of the tiles in `rows` of `image`, laid out like [`inputs`].
pub(super) fn output_gradients(
    image: &[f32],
    plane: Plane,
    rows: Range<usize>,
    out: &mut [f32],
    stride: usize,
    lines: &mut Vec<f32>,
) {
    by_width!(
        plane.across,
        output_gradients_of(image, plane, rows, out, stride, lines)
    );
}

/// A' m A + bias of tiles, into `rows` of `image`: value f of tile t is `products[f * apart + t]`.
pub(super) fn outputs(
    products: &[f32],
    apart: usize,
    bias: f32,
    image: &mut [f32],
    plane: Plane,
    rows: Range<usize>,
    lines: &mut Vec<f32>,
) {
    by_width!(
        plane.across,
        outputs_of(products, apart, bias, image, plane, rows, lines)
    );
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn inputs_of<const W: usize>(
    image: &[f32],
    plane: Plane,
    rows: Range<usize>,
    out: &mut [f32],
    stride: usize,
    lines: &mut Vec<f32>,
) {
    let n = if W == 0 { plane.across } else { W };
    let count = 2 * rows.len() + 2;
    lines.resize((count + 1) * 4 * n, 0.0);
    let (padded, lines) = lines.split_at_mut(4 * n);
    padded.fill(0.0);
    // Left to right, once a row of pixels.
    for (k, line) in lines.chunks_exact_mut(4 * n).enumerate() {
        let row = (2 * rows.start + k).checked_sub(plane.padding.0);
        let Some(row) = row.filter(|&r| r < plane.height) else {
            line.fill(0.0);
            continue;
        };
        let pixels = &image[row * plane.width..][..plane.width];
        let left = plane.padding.1;
        let seen = pixels.len().min(2 * n + 2 - left);
        padded[left..left + seen].copy_from_slice(&pixels[..seen]);
        let (l0, rest) = line.split_at_mut(n);
        let (l1, rest) = rest.split_at_mut(n);
        let (l2, l3) = rest.split_at_mut(n);
        let p = &padded[..2 * n + 2];
        for j in 0..n {
            let [d0, d1, d2, d3] = [p[2 * j], p[2 * j + 1], p[2 * j + 2], p[2 * j + 3]];
            l0[j] = d0 - d2;
            l1[j] = d1 + d2;
            l2[j] = d2 - d1;
            l3[j] = d1 - d3;
        }
    }
    // Top to bottom.
    for i in 0..rows.len() {
        let four = &lines[2 * i * 4 * n..][..16 * n];
        for b in 0..4 {
            let line = |k: usize| &four[(4 * k + b) * n..][..n];
            let [d0, d1, d2, d3] = [line(0), line(1), line(2), line(3)];
            let row = |a: usize| (4 * a + b) * stride + i * n;
            fill(&mut out[row(0)..][..n], |j| d0[j] - d2[j]);
            fill(&mut out[row(1)..][..n], |j| d1[j] + d2[j]);
            fill(&mut out[row(2)..][..n], |j| d2[j] - d1[j]);
            fill(&mut out[row(3)..][..n], |j| d1[j] - d3[j]);
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn output_gradients_of<const W: usize>(
    image: &[f32],
    plane: Plane,
    rows: Range<usize>,
    out: &mut [f32],
    stride: usize,
    lines: &mut Vec<f32>,
) {
    let n = if W == 0 { plane.across } else { W };
    lines.resize(2 * 4 * n + 2 * n, 0.0);
    let (padded, lines) = lines.split_at_mut(2 * n);
    padded.fill(0.0);
    for (i, tile_row) in rows.enumerate() {
        for (k, line) in lines.chunks_exact_mut(4 * n).enumerate() {
            let row = 2 * tile_row + k;
            if row >= plane.height {
                line.fill(0.0);
                continue;
            }
            padded[..plane.width].copy_from_slice(&image[row * plane.width..][..plane.width]);
            let (l0, rest) = line.split_at_mut(n);
            let (l1, rest) = rest.split_at_mut(n);
            let (l2, l3) = rest.split_at_mut(n);
            let p = &padded[..2 * n];
            for j in 0..n {
                let [y0, y1] = [p[2 * j], p[2 * j + 1]];
                l0[j] = y0;
                l1[j] = y0 + y1;
                l2[j] = y0 - y1;
                l3[j] = -y1;
            }
        }
        for b in 0..4 {
            let (y0, y1) = (&lines[b * n..][..n], &lines[(4 + b) * n..][..n]);
            let row = |a: usize| (4 * a + b) * stride + i * n;
            fill(&mut out[row(0)..][..n], |j| y0[j]);
            fill(&mut out[row(1)..][..n], |j| y0[j] + y1[j]);
            fill(&mut out[row(2)..][..n], |j| y0[j] - y1[j]);
            fill(&mut out[row(3)..][..n], |j| -y1[j]);
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
fn outputs_of<const W: usize>(
    products: &[f32],
    apart: usize,
    bias: f32,
    image: &mut [f32],
    plane: Plane,
    rows: Range<usize>,
    lines: &mut Vec<f32>,
) {
    let n = if W == 0 { plane.across } else { W };
    lines.resize(2 * 4 * n + 2 * n, 0.0);
    let (pixels, lines) = lines.split_at_mut(2 * n);
    for (i, tile_row) in rows.enumerate() {
        let (above, below) = lines.split_at_mut(4 * n);
        for b in 0..4 {
            let value = |a: usize| &products[(4 * a + b) * apart + i * n..][..n];
            let [m0, m1, m2, m3] = [value(0), value(1), value(2), value(3)];
            let (s0, s1) = (&mut above[b * n..][..n], &mut below[b * n..][..n]);
            for j in 0..n {
                s0[j] = m0[j] + m1[j] + m2[j];
                s1[j] = m1[j] - m2[j] - m3[j];
            }
        }
        for (k, line) in lines.chunks_exact(4 * n).enumerate() {
            let row = 2 * tile_row + k;
            if row >= plane.height {
                break;
            }
            let part = |b: usize| &line[b * n..][..n];
            let [s0, s1, s2, s3] = [part(0), part(1), part(2), part(3)];
            let pixels = &mut pixels[..2 * n];
            for j in 0..n {
                pixels[2 * j] = s0[j] + s1[j] + s2[j] + bias;
                pixels[2 * j + 1] = s1[j] - s2[j] - s3[j] + bias;
            }
            image[row * plane.width..][..plane.width].copy_from_slice(&pixels[..plane.width]);
        }
    }
}

/// G g G' of kernels (channels, 3, 3): value f of channel c at `out[f * channels + c]`. `taps` is working memory.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
pub(super) fn kernels(weights: &[f32], out: &mut [f32], taps: &mut Vec<f32>) {
    let n = weights.len() / 9;
    taps.resize(9 * n, 0.0);
    for (c, kernel) in weights.as_chunks::<9>().0.iter().enumerate() {
        for (k, &w) in kernel.iter().enumerate() {
            taps[k * n + c] = w;
        }
    }
    let tap = |row: usize, column: usize| &taps[(3 * row + column) * n..][..n];
    // Rows of G g, each then times G'.
    let [t0, t1, t2] = [0, 1, 2].map(|column| [tap(0, column), tap(1, column), tap(2, column)]);
    for (a, out) in out[..16 * n].chunks_exact_mut(4 * n).enumerate() {
        let (o0, rest) = out.split_at_mut(n);
        let (o1, rest) = rest.split_at_mut(n);
        let (o2, o3) = rest.split_at_mut(n);
        // Row `a` of G as three factors.
        let [f0, f1, f2] = [
            [1.0, 0.0, 0.0],
            [0.5, 0.5, 0.5],
            [0.5, -0.5, 0.5],
            [0.0, 0.0, 1.0],
        ][a];
        for c in 0..n {
            let column = |t: [&[f32]; 3]| f0 * t[0][c] + f1 * t[1][c] + f2 * t[2][c];
            let [k0, k1, k2] = [column(t0), column(t1), column(t2)];
            let (sum, middle) = (0.5 * (k0 + k2), 0.5 * k1);
            o0[c] = k0;
            o1[c] = sum + middle;
            o2[c] = sum - middle;
            o3[c] = k2;
        }
    }
}

/// G' u G, the way back for gradients: kernels (channels, 3, 3) from value f of channel c at `values[f * apart + c]`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2+fma"))]
pub(super) fn kernel_gradients(values: &[f32], apart: usize, out: &mut [f32], taps: &mut Vec<f32>) {
    let n = out.len() / 9;
    taps.resize(12 * n, 0.0);
    // G' u: three rows of four columns.
    for b in 0..4 {
        let value = |a: usize| &values[(4 * a + b) * apart..][..n];
        let [u0, u1, u2, u3] = [value(0), value(1), value(2), value(3)];
        for c in 0..n {
            let sum = 0.5 * (u1[c] + u2[c]);
            taps[b * n + c] = u0[c] + sum;
            taps[(4 + b) * n + c] = 0.5 * (u1[c] - u2[c]);
            taps[(8 + b) * n + c] = sum + u3[c];
        }
    }
    for (c, kernel) in out.as_chunks_mut::<9>().0.iter_mut().enumerate() {
        for row in 0..3 {
            let u = |b: usize| taps[(4 * row + b) * n + c];
            let sum = 0.5 * (u(1) + u(2));
            kernel[3 * row] = u(0) + sum;
            kernel[3 * row + 1] = 0.5 * (u(1) - u(2));
            kernel[3 * row + 2] = sum + u(3);
        }
    }
}

#[inline(always)]
fn fill(out: &mut [f32], value: impl Fn(usize) -> f32) {
    for (j, out) in out.iter_mut().enumerate() {
        *out = value(j);
    }
}
