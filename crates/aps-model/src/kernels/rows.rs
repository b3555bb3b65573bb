//! Matrices as rows of numbers.

use rayon::prelude::*;

/// Rows of one task.
pub(super) const ROWS: usize = 16;
/// Columns of one task of a sum over rows: four cache lines.
const COLUMNS: usize = 64;

/// The sum of all rows of `len` values, each column from the first row to the last in double precision.
pub(super) fn sum_rows(values: &[f32], len: usize) -> Vec<f32> {
    let mut out = vec![0.0; len];
    out.par_chunks_mut(COLUMNS)
        .enumerate()
        .for_each(|(block, out)| {
            let mut sums = [0.0f64; COLUMNS];
            for row in values.chunks_exact(len) {
                let row = &row[block * COLUMNS..][..out.len()];
                for (sum, &v) in sums.iter_mut().zip(row) {
                    *sum += f64::from(v);
                }
            }
            for (out, sum) in out.iter_mut().zip(sums) {
                *out = sum as f32;
            }
        });
    out
}
