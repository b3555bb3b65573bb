//! A function of each value, over all threads.

use rayon::prelude::*;

/// Values of one task.
const CHUNK: usize = 1 << 14;

/// `f` writes its third argument from the two others, in parts of `x` and `y`.
pub(super) fn zip_with(
    x: &[f32],
    y: &[f32],
    f: impl Fn(&[f32], &[f32], &mut [f32]) + Sync,
) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    out.par_chunks_mut(CHUNK)
        .zip(x.par_chunks(CHUNK).zip(y.par_chunks(CHUNK)))
        .for_each(|(out, (x, y))| f(x, y, out));
    out
}
