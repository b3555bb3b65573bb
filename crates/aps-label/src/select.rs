//! Selects the rows of a matrix that can win a maximum at all.
//!
//! A row i of S (one delay, say) is compared with those rows m(k) where each path k is largest,
//! with S_k(m(k)) = M_k. Choose lambda_m = max over the k of that row of S_k(i)/M_k: then
//! S_k(i) <= sum over m of lambda_m S_k(m) for every path, because all entries are >= 0. If the
//! lambdas sum to at most 1, then for any non-negative weights w
//!
//! sum_k w_k S_k(i) <= sum_m lambda_m sum_k w_k S_k(m) <= max_m sum_k w_k S_k(m),
//!
//! so the row never exceeds the best of the rows m: whatever the powers and angles. (One row
//! dominating another entry by entry is the case of a single lambda; with several paths it hardly
//! ever happens, while mixtures cover nearly all rows between the paths.)
//!
//! The sum has to stay below 1 by more than the rounding errors of lambda and of the two computed
//! sums, about (K + 4) 1.1e-16 each; the margin asked for is four times that. So a row left out is
//! strictly below the maximum as computed: leaving it out changes no bit of the result, the
//! position of the first maximum included.

use multiversion::multiversion;

use crate::product::{LANES, Lanes};

/// Finds the rows; keeps its buffers.
#[derive(Debug, Clone, Default)]
pub(crate) struct Selector {
    /// The row where each path is largest, the path, and the value there; in the order of the rows.
    peaks: Vec<(u32, u32, f64)>,
    lambda: Vec<Lanes>,
    /// The rows that remain, ascending.
    pub rows: Vec<u32>,
}

impl Selector {
    /// Fills `rows` with the candidates among the first `len` points of `matrix`, `[path][block]`
    /// with `blocks` to a path. Cost: two passes over the matrix.
    pub fn select(&mut self, matrix: &[Lanes], blocks: usize, len: usize) {
        let paths = matrix.len() / blocks;
        self.peaks.clear();
        for (k, row) in matrix.chunks_exact(blocks).enumerate() {
            let (at, value) = peak(row, len);
            // A path that is zero everywhere adds nothing to any row.
            if value > 0.0 {
                self.peaks.push((at as u32, k as u32, value));
            }
        }
        self.peaks.sort_unstable_by_key(|&(at, k, _)| (at, k));

        self.lambda.clear();
        self.lambda.resize(blocks, [0.0; LANES]);
        sum_lambdas(matrix, blocks, &self.peaks, &mut self.lambda);

        let limit = 1.0 - 4.0 * (paths + 4) as f64 * f64::EPSILON;
        let lambda = &self.lambda.as_flattened()[..len];
        self.rows.clear();
        self.rows
            .extend((0..len as u32).filter(|&i| lambda[i as usize] > limit));
        // Only if every path is zero everywhere: all rows are equal, the first one stands for them.
        if self.rows.is_empty() {
            self.rows.push(0);
        }
    }

    /// The row a maximum of this value belongs to, given its position among the rows kept. Where
    /// all rows are zero the first of them may have been left out, yet is the first of equals.
    pub fn winner(&self, maximum: f64, position: f64) -> usize {
        if maximum > 0.0 {
            self.rows[position as usize] as usize
        } else {
            0
        }
    }
}

/// The largest of the first `len` values, and where it is first.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn peak(row: &[Lanes], len: usize) -> (usize, f64) {
    let mut top = [0.0; LANES];
    let (whole, rest) = (
        &row[..len / LANES],
        &row.as_flattened()[len / LANES * LANES..len],
    );
    for block in whole {
        for l in 0..LANES {
            top[l] = if block[l] > top[l] { block[l] } else { top[l] };
        }
    }
    let mut highest = 0.0;
    for &value in top.iter().chain(rest) {
        highest = if value > highest { value } else { highest };
    }
    let mut at = 0;
    for block in whole {
        let mut any = false;
        for &value in block {
            any |= value == highest;
        }
        if any {
            break;
        }
        at += LANES;
    }
    while at + 1 < len && row.as_flattened()[at] != highest {
        at += 1;
    }
    (at, highest)
}

/// Adds to `lambda`, for each row that is some path's largest, the largest of these paths' shares.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn sum_lambdas(matrix: &[Lanes], blocks: usize, peaks: &[(u32, u32, f64)], lambda: &mut [Lanes]) {
    for same_row in peaks.chunk_by(|a, b| a.0 == b.0) {
        for (block, lambda) in lambda.iter_mut().enumerate() {
            let mut largest = [0.0; LANES];
            for &(_, k, peak) in same_row {
                let row = &matrix[k as usize * blocks + block];
                let scale = 1.0 / peak;
                for l in 0..LANES {
                    let share = row[l] * scale;
                    largest[l] = if share > largest[l] {
                        share
                    } else {
                        largest[l]
                    };
                }
            }
            for l in 0..LANES {
                lambda[l] += largest[l];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::{lane_maxima, pack_lanes, pack_rows};
    use crate::pulse::{in_lanes, pulses};
    use proptest::prelude::*;

    const POINTS: usize = 128;

    fn pulse_matrix(places: &[f64]) -> Vec<Lanes> {
        let mut axis = Vec::new();
        in_lanes((0..POINTS).map(|i| i as f64 * 1e-6 / 127.0), &mut axis);
        let mut matrix = vec![[0.0; LANES]; places.len() * axis.len()];
        pulses(200e6, &axis, places, &mut matrix);
        matrix
    }

    /// Maxima over the given rows: value and row.
    fn maxima(rows: &[u32], matrix: &[Lanes], weights: &[Lanes]) -> Vec<(f64, f64)> {
        let (mut lanes, mut packed) = (Vec::new(), Vec::new());
        pack_lanes(weights, 1, &mut lanes);
        pack_rows(matrix, POINTS / LANES, rows, &mut packed);
        let (mut best, mut first) = ([[0.0; LANES]], [[0.0; LANES]]);
        lane_maxima(weights.len(), &lanes, &packed, &mut best, &mut first);
        let row = |position: f64| f64::from(rows[position as usize]);
        best[0]
            .iter()
            .zip(first[0])
            .map(|(&best, first)| (best, row(first)))
            .collect()
    }

    proptest! {
        #[test]
        fn leaving_rows_out_does_not_change_a_bit(
            paths in prop::collection::vec(
                (0.0..1.3e-6, prop::array::uniform8(-300.0..0.0)),
                1..30,
            ),
            crowded in prop::bool::ANY,
        ) {
            let crowd = |tau: f64| if crowded { 4e-7 + 0.05 * tau } else { tau };
            let places: Vec<f64> = paths.iter().map(|p| crowd(p.0)).collect();
            let weights: Vec<Lanes> =
                paths.iter().map(|p| p.1.map(|db| libm::exp10(0.1 * db))).collect();
            let matrix = pulse_matrix(&places);
            let mut selector = Selector::default();
            selector.select(&matrix, POINTS / LANES, POINTS);
            let all: Vec<u32> = (0..POINTS as u32).collect();
            prop_assert_eq!(maxima(&selector.rows, &matrix, &weights), maxima(&all, &matrix, &weights));
        }
    }

    #[test]
    fn one_path_leaves_one_row() {
        let mut selector = Selector::default();
        selector.select(&pulse_matrix(&[3.21e-7]), POINTS / LANES, POINTS);
        assert_eq!(selector.rows, [41]);
    }

    #[test]
    fn twenty_paths_leave_most_rows_out() {
        let places: Vec<f64> = (0..20).map(|k| 1e-7 + f64::from(k * k) * 1.7e-9).collect();
        let mut selector = Selector::default();
        selector.select(&pulse_matrix(&places), POINTS / LANES, POINTS);
        assert!(selector.rows.len() <= 25, "{} rows", selector.rows.len());
    }

    #[test]
    fn where_all_is_zero_the_first_row_wins() {
        let mut selector = Selector::default();
        selector.select(&[[0.0; LANES]; 2], 2, 2 * LANES);
        assert_eq!(selector.rows, [0]);
        assert_eq!(selector.winner(0.0, 0.0), 0);
    }
}
