//! (batch, channel, pixel) to (channel, batch, pixel) and back: small images side by side.

use rayon::prelude::*;

/// Values between channels, so that they do not fall on the same cache lines.
pub(super) const GAP: usize = 16;

/// Channels of all images side by side: (channel, batch, pixel) of `x` (batch, channel, pixel), and how far the channels
/// are apart: not a power of two, so that they do not fall on the same cache lines.
pub(super) fn side_by_side(x: &[f32], channels: usize, pixels: usize) -> (Vec<f32>, usize) {
    let stride = x.len() / channels + GAP;
    let mut out = vec![0.0; channels * stride];
    out.par_chunks_mut(stride)
        .with_min_len(8)
        .enumerate()
        .for_each(|(c, row)| {
            let images = row[..stride - GAP].chunks_exact_mut(pixels);
            for (n, target) in images.enumerate() {
                target.copy_from_slice(&x[(n * channels + c) * pixels..][..pixels]);
            }
        });
    (out, stride)
}

/// Undoes the regrouping, into `out` (batch, channel, pixel).
pub(super) fn apart(x: &[f32], channels: usize, pixels: usize, out: &mut [f32]) {
    let batch = x.len() / (channels * pixels);
    out.par_chunks_mut(channels * pixels)
        .enumerate()
        .for_each(|(n, image)| {
            for (c, target) in image.chunks_exact_mut(pixels).enumerate() {
                target.copy_from_slice(&x[(c * batch + n) * pixels..][..pixels]);
            }
        });
}
