//! The maximum over a continuous delay, with a certificate.
//!
//! f(u) = sum_k w_k sinc^2(u - u_k), u in units of 1/f_s, is non-negative and an entire function of
//! exponential type 2 pi. Let M be its maximum, attained at u0. Two classical facts on such
//! functions, applied to f - M/2, whose modulus is at most M/2:
//!
//! - f(u) >= M cos^2(pi (u - u0)) for |u - u0| <= 1/2 (Duffin and Schaeffer, Bull. AMS 44, 1938).
//!   So the sample of the cell that holds u0 is at least [`Cell::share`](crate::cover::Cell::share) of M: every other cell is
//!   out.
//! - The n-th derivative of f is at most (2 pi)^n M/2 (Bernstein). So in a cell of half-width h <= 0.1725
//!   the polynomial p that agrees with f at eight Chebyshev nodes is off by at most
//!   (2 pi h)^8 M / (2 8! 2^7) <= 1.85e-7 M.
//!
//! For each column and each of its cells that remain, p's top is sought and p bounded; while the bound is
//! above (1 + `TOLERANCE`) times the best value found, the cell is halved. The label is the highest
//! value of p, by the above from (1 - 1.85e-7 - `TOLERANCE`) M to (1 + 1.85e-7) M.
//!
//! Samples are in single precision, and have a bound in place of each pulse that is far: they only have
//! to tell which cells remain.

mod pieces;
mod samples;
mod scratch;
mod settle;

use multiversion::multiversion;

use crate::cover::cover;
use crate::polynomial::NODES;
use crate::product::{LANES, Lanes};
use crate::protocol::FLOOR_POWER;
use crate::pulse::pulses;
use pieces::Piece;
use samples::{pack_weights, sample};
pub(crate) use scratch::Continuous;
use scratch::WIDE;
use settle::settle;

/// Sums that are made at once: each addition waits for the one before in its own sum.
const TOGETHER: usize = 4;

impl Continuous {
    /// Maxima for the first `columns` columns of `response`, `[path][block]` with `blocks` to a path.
    /// Returns the delay that places are relative to \[s\].
    pub fn search(
        &mut self,
        delays_s: &[f64],
        sampling_rate_hz: f64,
        response: &[Lanes],
        blocks: usize,
        columns: usize,
    ) -> f64 {
        let earliest = delays_s.iter().copied().fold(f64::INFINITY, f64::min);
        self.sorted.clear();
        self.sorted.extend(
            delays_s
                .iter()
                .map(|tau| sampling_rate_hz * (tau - earliest)),
        );
        self.places.clone_from(&self.sorted);
        self.sorted.sort_unstable_by(f64::total_cmp);
        cover(&self.sorted, &mut self.points, &mut self.cells);
        self.pulses.resize(delays_s.len(), [0.0; LANES]);
        self.best.clear();
        self.best.resize(blocks, [0.0; LANES]);
        self.place.clear();
        self.place.resize(blocks, [0.0; LANES]);
        search(self, response, columns);
        earliest
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn search(search: &mut Continuous, response: &[Lanes], columns: usize) {
    let stride = search.best.len() * LANES;
    pack_weights(response, search.best.len(), &mut search.weights);
    sample(search);
    // Less room for the rounding of the samples.
    let room = 1.0 - 2.0 * (search.pulses.len() + 4) as f32 * f32::EPSILON;
    for (column, least) in search.least.as_flattened_mut().iter_mut().enumerate() {
        // The maximum is at most twice the largest sample: here it is below the label's floor.
        let searched = *least >= 0.5 * FLOOR_POWER as f32 && column < columns;
        *least = if searched {
            room * *least
        } else {
            f32::INFINITY
        };
    }
    let response = response.as_flattened();
    interpolate(search, response, stride);
    settle(search);
}

/// Finds the cells that remain for each column, and interpolates f there.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn interpolate(search: &mut Continuous, response: &[f64], stride: usize) {
    search.pieces.clear();
    let blocks = search.least.len();
    search.remaining.resize(blocks * WIDE + 1, 0);
    for (cell, samples) in search.cells.iter().zip(search.samples.chunks_exact(blocks)) {
        let share = cell.share as f32;
        let mut count = 0;
        for (block, (sample, least)) in samples.iter().zip(&search.least).enumerate() {
            let mut any = false;
            for l in 0..WIDE {
                any |= sample[l] >= share * least[l];
            }
            if any {
                for l in 0..WIDE {
                    search.remaining[count] = block * WIDE + l;
                    count += usize::from(sample[l] >= share * least[l]);
                }
            }
        }
        let remaining = &search.remaining[..count];
        if remaining.is_empty() {
            continue;
        }
        let (middle, half_width) = (0.5 * (cell.low + cell.high), 0.5 * (cell.high - cell.low));
        let nodes = NODES.map(|x| middle + half_width * x);
        pulses(1.0, &[nodes], &search.places, &mut search.pulses);
        for columns in remaining.chunks(TOGETHER) {
            let padded: [usize; TOGETHER] =
                std::array::from_fn(|c| columns[c.min(columns.len() - 1)]);
            let mut values = [[0.0; LANES]; TOGETHER];
            for (pulse, row) in search.pulses.iter().zip(response.chunks_exact(stride)) {
                let weights = padded.map(|column| row[column]);
                for c in 0..TOGETHER {
                    for l in 0..LANES {
                        values[c][l] += weights[c] * pulse[l];
                    }
                }
            }
            for (&column, values) in columns.iter().zip(values) {
                let piece = Piece {
                    column,
                    middle,
                    half_width,
                    upper: 0.0,
                };
                search.pieces.push(piece, values);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trig::sinc_squared;
    use proptest::prelude::*;

    /// 1e-6 dB.
    const PROMISED: f64 = 2.3e-7;

    /// The search for paths at these places [1/f_s], each with a weight a lane.
    fn search(places: &[f64], weights: &[Lanes]) -> Continuous {
        let mut search = Continuous::default();
        search.search(places, 1.0, weights, 1, LANES);
        search
    }

    fn f(places: &[f64], weights: &[Lanes], lane: usize, u: f64) -> f64 {
        let terms = places.iter().zip(weights);
        terms.map(|(at, w)| w[lane] * sinc_squared(u - at)).sum()
    }

    /// The maximum by 40 points a unit of u and golden section around each that its neighbours do not
    /// exceed.
    fn brute_force(places: &[f64], weights: &[Lanes], lane: usize) -> f64 {
        const STEP: f64 = 0.025;
        let f = |u: f64| f(places, weights, lane, u);
        let first = places.iter().copied().fold(f64::INFINITY, f64::min) - 1.0;
        let last = places.iter().copied().fold(0.0, f64::max) + 1.0;
        let count = ((last - first) / STEP) as usize;
        let values: Vec<f64> = (0..=count).map(|i| f(first + STEP * i as f64)).collect();
        let coarse = values.iter().copied().fold(0.0, f64::max);
        let mut best = coarse;
        for i in 1..count {
            // A top is at most cos^2(pi STEP/2) higher than the nearest point.
            if values[i] < 0.99 * coarse || values[i] < values[i - 1].max(values[i + 1]) {
                continue;
            }
            let (mut low, mut high) =
                (first + STEP * (i - 1) as f64, first + STEP * (i + 1) as f64);
            while high - low > 1e-6 {
                let third = (high - low) / 3.0;
                if f(low + third) < f(high - third) {
                    low += third;
                } else {
                    high -= third;
                }
            }
            best = best.max(f(0.5 * (low + high)));
        }
        best
    }

    /// Two equal pulses merge into one with a top as flat as a quartic: the hardest case for a bound
    /// by derivatives.
    #[test]
    fn flat_top_is_settled_by_some_polynomials() {
        let mut most = 0;
        for i in 0..400 {
            let places = [0.0, 0.7 + f64::from(i) * 5e-4];
            let search = search(&places, &[[1.0; LANES]; 2]);
            most = most.max(search.polynomials / LANES);
            let highest = brute_force(&places, &[[1.0; LANES]; 2], 0);
            assert!(search.best[0][0] >= highest * (1.0 - PROMISED));
        }
        assert!(most < 60, "{most} polynomials");
    }

    #[test]
    fn weights_of_zero_have_the_maximum_zero() {
        let search = search(&[0.0, 3.0], &[[0.0; LANES]; 2]);
        assert_eq!(search.best, [[0.0; LANES]]);
    }

    /// Delays spread, crowded, or in clusters, some of them equal; powers over 300 dB.
    fn links(paths: std::ops::Range<usize>) -> impl Strategy<Value = (Vec<f64>, Vec<Lanes>)> {
        let path = (0.0..12.0, prop::array::uniform8(0.0..1.0), 0_u32..4);
        let range_db = prop::sample::select(vec![3.0, 40.0, 300.0]);
        (prop::collection::vec(path, paths), 0.02..3.0, range_db).prop_map(
            |(paths, crowd, range_db)| {
                let place = |at: f64, kind: u32| match kind {
                    0 => crowd * at.floor(),
                    1 => crowd * (at.floor() + 0.1 * at.fract()),
                    _ => crowd * at,
                };
                let weight = |x: f64| libm::exp10(-0.1 * range_db * x);
                paths
                    .iter()
                    .map(|p| (place(p.0, p.2), p.1.map(weight)))
                    .unzip()
            },
        )
    }

    fn check((places, weights): (Vec<f64>, Vec<Lanes>)) -> Result<f64, TestCaseError> {
        let first = places.iter().copied().fold(f64::INFINITY, f64::min);
        let search = search(&places, &weights);
        let mut worst = 0.0_f64;
        for lane in 0..LANES {
            let (best, place) = (search.best[0][lane], first + search.place[0][lane]);
            let at_place = f(&places, &weights, lane, place);
            prop_assert!(
                (best - at_place).abs() <= PROMISED * best,
                "{} is not {}",
                best,
                at_place
            );
            let highest = brute_force(&places, &weights, lane);
            worst = worst.max((best / highest - 1.0).abs());
            prop_assert!(
                (best - highest).abs() <= PROMISED * highest,
                "{} {}",
                best,
                highest
            );
        }
        Ok(worst)
    }

    proptest! {
        #[test]
        fn brute_force_finds_no_higher_value(link in links(1..20)) {
            check(link)?;
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(8))]
        #[test]
        fn brute_force_finds_no_higher_value_among_many_paths(link in links(100..201)) {
            check(link)?;
        }
    }

    /// The figure of the documentation.
    #[test]
    #[ignore = "long: takes minutes"]
    fn worst_error_of_many_links() {
        use proptest::strategy::ValueTree;
        use proptest::test_runner::TestRunner;
        let mut runner = TestRunner::deterministic();
        let mut worst = 0.0_f64;
        for i in 0..20_000 {
            let paths = if i % 50 == 0 { 100..201 } else { 1..20 };
            let link = links(paths)
                .new_tree(&mut runner)
                .expect("a link")
                .current();
            worst = worst.max(check(link).expect("within the promise"));
        }
        eprintln!(
            "worst {:e} dB of {} maxima",
            10.0 * worst.ln_1p() / std::f64::consts::LN_10,
            20_000 * LANES
        );
    }
}
