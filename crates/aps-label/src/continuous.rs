//! The maximum over a continuous delay, with a certificate.
//!
//! f(u) = sum_k w_k sinc^2(u - u_k), u in units of 1/f_s, is non-negative and an entire function of
//! exponential type 2 pi. Let M be its maximum, attained at u0. Two classical facts on such
//! functions, applied to f - M/2, whose modulus is at most M/2:
//!
//! - f(u) >= M cos^2(pi (u - u0)) for |u - u0| <= 1/2 (Duffin and Schaeffer, Bull. AMS 44, 1938).
//!   So the sample of the cell that holds u0 is at least [`Cell::share`] of M: every other cell is
//!   out. With half-width 1/4 that is one half, whatever the paths.
//! - |f''''| <= (2 pi)^4 M/2 (Bernstein). So with f and three derivatives known at c,
//!   f(c + t) <= f + f' t + f'' t^2/2 + f''' t^3/6 + (2 pi)^4 M t^4/48.
//!
//! In each remaining cell Newton steps find the top; then the second fact excludes an interval
//! around the point reached, and what it leaves of the cell is searched the same way. To show
//! M <= T := (1 + [`TOLERANCE`]) times the best value found, M in the fourth-order term may be
//! replaced by T: were M larger and attained at distance t <= 0.4 from c, then
//! M (1 - 32.5 t^4) <= the cubic <= T (1 - 32.5 t^4).
//!
//! The pulses' derivatives at the sample points serve all angles, so that a lone pulse needs no further
//! evaluation and 20 paths need two for each angle.

use std::f64::consts::PI;
use std::ops::Range;

use multiversion::multiversion;

use crate::cover::{Cell, cover};
use crate::jet::{Jet, Pulses};
use crate::product::{LANES, Lanes, ROWS, group_sums, pack_lanes, pack_rows};
use crate::protocol::FLOOR_POWER;
use crate::pulse::{in_lanes, pulses};

/// Guaranteed relative error of the maximum: 4.3e-11 dB. What is found is usually exact to
/// rounding; the certificate is what gets longer with a smaller tolerance.
const TOLERANCE: f64 = 1e-11;

/// (2 pi)^4 / 48, the factor of M t^4 in Taylor's remainder.
const FOURTH: f64 = 32.469_697_011_334_15;

/// The argument for the fourth-order term needs 32.5 t^4 < 1.
const FARTHEST: f64 = 0.4;

/// Newton steps at most; a start within 1/4 of a top needs one to three.
const NEWTON_STEPS: usize = 8;

/// Sample points times paths whose pulses are held at once: 32 MiB. Links of up to 1400 paths, none
/// closer than half a pulse, are below it.
const MAX_MATRIX: usize = 1 << 22;

/// Numbers held of the pulses and their derivatives at sample points: 128 MiB.
const MAX_SHARED: usize = 1 << 24;

/// Scratch space of the search.
#[derive(Debug, Clone, Default)]
pub(crate) struct Continuous {
    /// u_k, in the order of the paths, and sorted.
    places: Vec<f64>,
    sorted: Vec<f64>,
    points: Vec<f64>,
    cells: Vec<Cell>,
    pulses: Pulses,
    point_lanes: Vec<Lanes>,
    matrix: Vec<Lanes>,
    selected: Vec<u32>,
    rows: Vec<[f64; ROWS]>,
    lanes: Vec<Lanes>,
    /// At each sample point, of one block or, block after block, of all.
    samples: Vec<Lanes>,
    /// Whether `samples` are those of all blocks.
    all_sampled: bool,
    /// The pulses' terms at each sample point, made when first wanted: all columns share them.
    /// Not more than [`MAX_SHARED`] of them.
    at_samples: Vec<f64>,
    /// Where a sample point's terms begin, if they are made.
    made: Vec<Option<usize>>,
    at_point: Vec<f64>,
    weights: Vec<Lanes>,
    rest: Vec<(f64, f64)>,
    /// Per column: the maximum, and where it is [1/f_s after the first path].
    pub best: Vec<Lanes>,
    pub place: Vec<Lanes>,
    /// Evaluations of f and its derivatives in the last search.
    pub evaluations: usize,
}

impl Continuous {
    /// Maxima for each column of `response`, `[path][block]` with `blocks` to a path. Returns the
    /// delay that places are relative to \[s\].
    pub fn search(
        &mut self,
        delays_s: &[f64],
        sampling_rate_hz: f64,
        response: &[Lanes],
        blocks: usize,
    ) -> f64 {
        let earliest = delays_s.iter().copied().fold(f64::INFINITY, f64::min);
        self.places.clear();
        self.places.extend(
            delays_s
                .iter()
                .map(|&tau| sampling_rate_hz * (tau - earliest)),
        );
        self.sorted.clone_from(&self.places);
        self.sorted.sort_unstable_by(f64::total_cmp);
        cover(&self.sorted, &mut self.points, &mut self.cells);
        self.pulses.set(&self.places);

        pack_lanes(response, blocks, &mut self.lanes);
        let paths = delays_s.len();
        self.weights.clear();
        self.weights.resize(paths.div_ceil(LANES), [0.0; LANES]);
        self.best.resize(blocks, [0.0; LANES]);
        self.place.resize(blocks, [0.0; LANES]);
        let size = self.cells.len().next_multiple_of(ROWS);
        let most = (MAX_MATRIX / paths).next_multiple_of(ROWS);
        self.all_sampled = self.cells.len() > most;
        if !self.all_sampled {
            self.samples.resize(size, [0.0; LANES]);
            self.pack_pulses(0..self.cells.len());
        } else {
            self.samples.resize(blocks * size, [0.0; LANES]);
            for first in (0..self.cells.len()).step_by(most) {
                self.pack_pulses(first..self.cells.len().min(first + most));
                for (lanes, samples) in
                    (self.lanes.chunks_exact(paths)).zip(self.samples.chunks_exact_mut(size))
                {
                    sample(lanes, &self.rows, &mut samples[first..]);
                }
            }
        }
        self.at_samples.clear();
        self.at_point.resize(self.pulses.terms_len(), 0.0);
        self.made.clear();
        self.made.resize(self.cells.len(), None);
        self.evaluations = 0;
        search_blocks(self, paths);
        earliest
    }

    /// The pulses of all paths at the sample points of some cells, into `rows`.
    fn pack_pulses(&mut self, cells: Range<usize>) {
        let points = self.cells[cells.clone()].iter().map(|cell| cell.at);
        in_lanes(points, &mut self.point_lanes);
        let point_blocks = self.point_lanes.len();
        self.matrix
            .resize(self.places.len() * point_blocks, [0.0; LANES]);
        pulses(1.0, &self.point_lanes, &self.places, &mut self.matrix);
        self.selected.clear();
        self.selected.extend(0..cells.len() as u32);
        pack_rows(&self.matrix, point_blocks, &self.selected, &mut self.rows);
    }

    /// Number of sample points in the last search.
    pub fn delays(&self) -> usize {
        self.cells.len()
    }
}

/// f at the sample points in `rows`, for the columns in `lanes`.
#[inline(always)]
fn sample_inline(lanes: &[Lanes], rows: &[[f64; ROWS]], samples: &mut [Lanes]) {
    let groups = rows.chunks_exact(lanes.len());
    for (group, samples) in groups.zip(samples.chunks_exact_mut(ROWS)) {
        samples.copy_from_slice(&group_sums(lanes, group));
    }
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn sample(lanes: &[Lanes], rows: &[[f64; ROWS]], samples: &mut [Lanes]) {
    sample_inline(lanes, rows, samples);
}

#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn search_blocks(search: &mut Continuous, paths: usize) {
    let size = search.cells.len().next_multiple_of(ROWS);
    for (block, lanes) in search.lanes.chunks_exact(paths).enumerate() {
        let samples = if search.all_sampled {
            &search.samples[block * size..][..size]
        } else {
            sample_inline(lanes, &search.rows, &mut search.samples);
            &search.samples
        };
        for l in 0..LANES {
            for (weight, w) in search.weights.as_flattened_mut().iter_mut().zip(lanes) {
                *weight = w[l];
            }
            let mut hunt = Hunt {
                pulses: &search.pulses,
                at_samples: &mut search.at_samples,
                made: &mut search.made,
                at_point: &mut search.at_point,
                weights: &search.weights,
                rest: &mut search.rest,
                best: 0.0,
                place: 0.0,
                evaluations: 0,
            };
            hunt.column(&search.cells, samples, l);
            search.best[block][l] = hunt.best;
            search.place[block][l] = hunt.place;
            search.evaluations += hunt.evaluations;
        }
    }
}

/// The search for one column's maximum.
struct Hunt<'a> {
    pulses: &'a Pulses,
    at_samples: &'a mut Vec<f64>,
    made: &'a mut [Option<usize>],
    at_point: &'a mut [f64],
    weights: &'a [Lanes],
    rest: &'a mut Vec<(f64, f64)>,
    best: f64,
    place: f64,
    evaluations: usize,
}

impl Hunt<'_> {
    #[inline(always)]
    fn column(&mut self, cells: &[Cell], samples: &[Lanes], lane: usize) {
        let mut top = 0;
        for (i, sample) in samples[..cells.len()].iter().enumerate() {
            if sample[lane] > samples[top][lane] {
                top = i;
            }
        }
        // The maximum is at most twice the largest sample, so here it is below the label's floor.
        let sample = samples[top][lane];
        if sample < 0.5 * FLOOR_POWER {
            (self.best, self.place) = (sample, cells[top].at);
            return;
        }
        self.cell(top, &cells[top]);
        for (i, (cell, sample)) in cells.iter().zip(samples).enumerate() {
            // The product's sums and the jet's differ by rounding.
            if sample[lane] >= cell.share * (1.0 - 1e-9) * self.best && i != top {
                self.cell(i, cell);
            }
        }
    }

    /// Searches one cell; afterwards no point of it is above (1 + TOLERANCE) times the best.
    #[inline(always)]
    fn cell(&mut self, index: usize, cell: &Cell) {
        self.rest.clear();
        let (mut low, mut high) = (cell.low, cell.high);
        let mut at = cell.at;
        let mut jet = self.jet_at_sample(index, at);
        loop {
            let mut below = excluded(&jet, -1.0, at - low, self.best);
            let mut above = excluded(&jet, 1.0, high - at, self.best);
            if below < at - low || above < high - at || jet.f > self.best {
                (at, jet) = self.climb(at, jet, low, high);
                if jet.f > self.best {
                    (self.best, self.place) = (jet.f, at);
                }
                below = excluded(&jet, -1.0, at - low, self.best);
                above = excluded(&jet, 1.0, high - at, self.best);
            }
            // No two places closer than this are told apart: what is left must be less than before.
            let resolution = 2.0 * f64::EPSILON * high.abs().max(low.abs());
            let (below, above) = (below.max(resolution), above.max(resolution));
            if below < at - low {
                self.rest.push((low, at - below));
            }
            if above < high - at {
                self.rest.push((at + above, high));
            }
            let Some(next) = self.rest.pop() else {
                return;
            };
            (low, high) = next;
            at = 0.5 * (low + high);
            jet = self.jet(at);
        }
    }

    /// Newton steps towards a top, with the third derivative's correction (Halley's method on f'),
    /// as long as they gain.
    #[inline(always)]
    fn climb(&mut self, mut at: f64, mut jet: Jet, low: f64, high: f64) -> (f64, Jet) {
        for _ in 0..NEWTON_STEPS {
            if jet.d2 >= 0.0 {
                break;
            }
            let newton = -jet.d1 / jet.d2;
            let curvature = jet.d2 + 0.5 * jet.d3 * newton;
            let step = if curvature < 0.0 {
                -jet.d1 / curvature
            } else {
                newton
            };
            let next = (at + step).clamp(low, high);
            if (jet.d1 * (next - at)).abs() <= 0.1 * TOLERANCE * jet.f {
                break;
            }
            let ahead = self.jet(next);
            if ahead.f <= jet.f {
                break;
            }
            (at, jet) = (next, ahead);
        }
        (at, jet)
    }

    #[inline(always)]
    fn jet(&mut self, at: f64) -> Jet {
        self.evaluations += 1;
        self.pulses.terms(at, self.at_point);
        Jet::sum(self.at_point, self.weights)
    }

    #[inline(always)]
    fn jet_at_sample(&mut self, index: usize, at: f64) -> Jet {
        let size = self.pulses.terms_len();
        let begin = match self.made[index] {
            Some(begin) => begin,
            None if self.at_samples.len() + size > MAX_SHARED => return self.jet(at),
            None => {
                let begin = self.at_samples.len();
                self.at_samples.resize(begin + size, 0.0);
                self.pulses.terms(at, &mut self.at_samples[begin..]);
                self.made[index] = Some(begin);
                begin
            }
        };
        let terms = &self.at_samples[begin..begin + size];
        Jet::sum(terms, self.weights)
    }
}

/// How far from the jet's point, at most `reach`, f is certain not to exceed
/// (1 + TOLERANCE) `best` in the direction of `sign`.
#[inline(always)]
fn excluded(jet: &Jet, sign: f64, reach: f64, best: f64) -> f64 {
    let top = best * (1.0 + TOLERANCE);
    let room = top - jet.f;
    if room <= 0.0 {
        return 0.0;
    }
    let slope = sign * jet.d1;
    let cubic = (sign * jet.d3).max(0.0) / 6.0;
    let mut t = reach.min(FARTHEST);
    // On [0, t] the bound minus f is at most slope s + bend s^2, a parabola.
    loop {
        let bend = 0.5 * jet.d2 + t * (cubic + FOURTH * top * t);
        let highest = if bend < 0.0 && slope > 0.0 && slope < -2.0 * bend * t {
            slope * slope / (-4.0 * bend)
        } else {
            (t * (slope + bend * t)).max(0.0)
        };
        if highest <= room {
            return t;
        }
        t *= 0.75;
        // Too small to be told from the point itself.
        if t < 1e-15 * PI {
            return 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trig::sinc_squared;
    use proptest::prelude::*;

    /// The search for paths at these places [1/f_s], each with a weight a lane.
    fn search(places: &[f64], weights: &[Lanes]) -> Continuous {
        let mut search = Continuous::default();
        search.search(places, 1.0, weights, 1);
        search
    }

    fn f(places: &[f64], weights: &[Lanes], lane: usize, u: f64) -> f64 {
        let terms = places.iter().zip(weights);
        terms.map(|(at, w)| w[lane] * sinc_squared(u - at)).sum()
    }

    /// Two equal pulses merge into one with a top as flat as a quartic: the hardest case for a bound
    /// by derivatives.
    #[test]
    fn flat_top_is_settled_within_a_few_hundred_evaluations() {
        let mut most = 0;
        for i in 0..400 {
            let places = [0.0, 0.7 + f64::from(i) * 5e-4];
            let search = search(&places, &[[1.0; LANES]; 2]);
            most = most.max(search.evaluations / LANES);
            let middle = f(&places, &[[1.0; LANES]; 2], 0, 0.5 * places[1]);
            assert!(search.best[0][0] >= middle * (1.0 - 1e-15));
        }
        assert!(most < 300, "{most} evaluations");
    }

    #[test]
    fn weights_of_zero_have_the_maximum_zero() {
        let search = search(&[0.0, 3.0], &[[0.0; LANES]; 2]);
        assert_eq!(search.best, [[0.0; LANES]]);
    }

    proptest! {
        #[test]
        fn nothing_on_a_dense_grid_is_above_the_certified_maximum(
            paths in prop::collection::vec((0.0..12.0, prop::array::uniform8(-40.0..0.0)), 1..20),
            crowd in 0.02..1.0,
        ) {
            let places: Vec<f64> = paths.iter().map(|path| path.0 * crowd).collect();
            let first = places.iter().copied().fold(f64::INFINITY, f64::min);
            let weights: Vec<Lanes> =
                paths.iter().map(|path| path.1.map(|db| libm::exp10(0.1 * db))).collect();
            let search = search(&places, &weights);
            for lane in 0..LANES {
                let (best, place) = (search.best[0][lane], first + search.place[0][lane]);
                let at_place = f(&places, &weights, lane, place);
                prop_assert!((best - at_place).abs() <= 1e-13 * best, "{} is not {}", best, at_place);
                // Coarse everywhere, fine around the place found.
                let everywhere = (0..1500).map(|i| first - 1.5 + f64::from(i) * 0.01);
                let around = (-50..=50).map(|i| place + f64::from(i) * 1e-5);
                for u in everywhere.chain(around) {
                    let value = f(&places, &weights, lane, u);
                    prop_assert!(value <= best * (1.0 + TOLERANCE + 1e-14), "f({}) = {} > {}", u, value, best);
                }
            }
        }
    }
}
