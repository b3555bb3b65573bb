//! Intervals in which the maximum over a continuous delay lies.
//!
//! Delays are in units of 1/f_s, so the pulse is g(x) = sinc^2(x) and f = sum_k w_k g(u - u_k) with
//! weights w_k >= 0. The line is covered by cells of half-width at most 0.1725, each with a sample
//! point inside; the cells left out cannot hold the maximum for any choice of weights:
//!
//! *Mixtures.* If numbers c_i >= 0 with sum below 1 and points v_i satisfy
//! g(u - u_k) <= sum_i c_i g(v_i - u_k) for every path k, then f(u) <= sum_i c_i f(v_i), which is
//! below max f: u is not where f is largest.
//!
//! - With the v_i at the paths themselves and c_i = g(u - u_i): u is out if sum_k g(u - u_k) < 1.
//!   A cell is out if that holds with each g replaced by its bound over the cell.
//! - Farther than 3/4 from every path: take v_i at distances 0, 1/2, 1, 3/2, ... behind the nearest
//!   path on either side. Each path is within 1/4 of one of them, where g >= 0.81; the c_i needed
//!   on one side sum to less than 0.45, on both to less than 0.9.

use std::f64::consts::PI;

use multiversion::multiversion;

/// Largest distance of neighbouring sample points inside the cover, and largest width of a cell.
pub(crate) const SPACING: f64 = 0.345;
/// A path this close to the last sample point gets none of its own.
const CLOSE: f64 = 0.75 * SPACING;
/// The cover reaches this far from every path.
const REACH: f64 = 0.75;

/// Cells looked at together.
const AT_ONCE: usize = 16;

/// One cell of the cover.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cell {
    /// The sample point.
    pub at: f64,
    pub low: f64,
    pub high: f64,
    /// At most cos^2(pi r), r the larger distance from the sample point to the cell's ends: if the
    /// maximum of f lies in the cell, the sample is at least this share of it.
    pub share: f64,
}

/// Fills `cells`, ascending, for the places of the paths, ascending. `points` is scratch space.
pub(crate) fn cover(places: &[f64], points: &mut Vec<f64>, cells: &mut Vec<Cell>) {
    sample_points(places, points);
    cells.clear();
    let mut before = 0.5 * SPACING;
    for (i, &at) in points.iter().enumerate() {
        let to_next = points.get(i + 1).map_or(SPACING, |next| next - at);
        let after = 0.5 * to_next.min(SPACING);
        let z = (PI * before.max(after)) * (PI * before.max(after));
        cells.push(Cell {
            at,
            low: at - before,
            high: at + after,
            // Four terms of the alternating series.
            share: 1.0 - z * (1.0 - z * (1.0 / 3.0 - z * (2.0 / 45.0))),
        });
        before = after;
    }
    keep_possible(places, cells);
}

/// Drops the cells where the bound of sum_k g(u - u_k) leaves no room for the maximum.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn keep_possible(places: &[f64], cells: &mut Vec<Cell>) {
    // Room for the rounding of the sums.
    let limit = 1.0 - 4.0 * (places.len() + 8) as f32 * f32::EPSILON;
    let mut kept = 0;
    for first in (0..cells.len()).step_by(AT_ONCE) {
        let (mut middle, mut half) = ([0.0; AT_ONCE], [0.0_f32; AT_ONCE]);
        let last = AT_ONCE.min(cells.len() - first);
        for i in 0..last {
            let Cell { low, high, .. } = cells[first + i];
            (middle[i], half[i]) = (0.5 * (low + high), 0.5 * (high - low) as f32);
        }
        let mut sum = [0.0; AT_ONCE];
        for place in places {
            for i in 0..AT_ONCE {
                let distance = ((middle[i] - place) as f32).abs() - half[i];
                sum[i] += pulse_bound(distance);
            }
        }
        for (i, sum) in sum[..last].iter().enumerate() {
            cells[kept] = cells[first + i];
            kept += usize::from(*sum > limit);
        }
    }
    cells.truncate(kept);
}

/// Sample points at most [`SPACING`] apart within [`REACH`] of every path, on the paths themselves
/// unless these crowd.
fn sample_points(places: &[f64], points: &mut Vec<f64>) {
    points.clear();
    let mut before = f64::NEG_INFINITY;
    for &place in places {
        let last = points.last().copied().unwrap_or(before);
        let gap = place - last;
        if place - before > 2.0 * (REACH + SPACING) {
            extend_to(before + REACH, points);
            points.extend([place - 2.0 * SPACING, place - SPACING, place]);
        } else if gap > CLOSE {
            let steps = (gap / SPACING).ceil();
            let mut step = 1.0;
            while step < steps {
                points.push(last + gap * (step / steps));
                step += 1.0;
            }
            points.push(place);
        }
        before = place;
    }
    extend_to(before + REACH, points);
}

/// Adds points until the cell of the last one reaches `end`.
fn extend_to(end: f64, points: &mut Vec<f64>) {
    while let Some(&last) = points.last()
        && last + 0.5 * SPACING < end
    {
        points.push(last + SPACING);
    }
}

/// A falling upper bound of g on distances >= 0: the power series of sinc^2, cut after a positive
/// term, up to 0.8; then the height 0.0554 it has reached or the envelope, whichever is less.
#[inline(always)]
fn pulse_bound(distance: f32) -> f32 {
    let y = std::f32::consts::PI * if distance > 0.0 { distance } else { 0.0 };
    let z = y * y;
    let near = 1.0 + z * (-1.0 / 3.0 + z * (2.0 / 45.0 + z * (-1.0 / 315.0 + z * (2.0 / 14175.0))));
    let envelope = 1.0 / z;
    let far = if envelope < 0.0554 { envelope } else { 0.0554 };
    if z < 6.3 { near } else { far }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trig::sinc_squared;
    use proptest::prelude::*;

    fn cells(places: &[f64]) -> Vec<Cell> {
        let (mut points, mut cells) = (Vec::new(), Vec::new());
        cover(places, &mut points, &mut cells);
        cells
    }

    #[test]
    fn lone_path_has_one_cell() {
        let cells = cells(&[0.0]);
        assert_eq!(cells.len(), 1);
        assert_eq!(
            (cells[0].low, cells[0].at, cells[0].high),
            (-0.5 * SPACING, 0.0, 0.5 * SPACING)
        );
    }

    #[test]
    fn paths_far_apart_have_a_cell_each() {
        let places = [0.0, 10.0, 1e8];
        let at: Vec<f64> = cells(&places).iter().map(|cell| cell.at).collect();
        assert_eq!(at, places);
    }

    #[test]
    fn bound_of_the_pulse_falls_and_holds() {
        let mut last = f64::INFINITY;
        for i in 0..100_000 {
            let x = f64::from(i) * 1e-4;
            let bound = f64::from(pulse_bound(x as f32));
            // Rounding of single precision, for which the sums of bounds have room.
            let rounding = 3e-7;
            assert!(
                bound <= last + rounding && bound + rounding >= sinc_squared(x),
                "x = {x}"
            );
            last = bound;
        }
    }

    #[test]
    fn mixture_behind_one_path_needs_less_than_half() {
        // c_i = sup g(y + REACH) / 0.81 over the places y within 1/4 of i/2, behind the nearest path.
        let head: f64 = (0..2000)
            .map(|i| pulse_bound((REACH + (f64::from(i) * 0.5 - 0.25).max(0.0)) as f32))
            .map(f64::from)
            .sum();
        // The rest is below 1/(pi^2 x^2), summed in steps of 1/2 from 999.
        assert!((head + 2.0 / (PI * PI * 999.0)) / 0.81 < 0.45);
    }

    proptest! {
        #[test]
        fn maximum_lies_in_a_cell(
            mut places in prop::collection::vec(0.0..40.0, 1..25),
            crowd in 0.05..1.0,
            weights in prop::collection::vec(0.0..1.0, 25),
        ) {
            places.iter_mut().for_each(|u| *u *= crowd);
            places.sort_unstable_by(f64::total_cmp);
            let f = |u: f64| -> f64 { places.iter().zip(&weights).map(|(p, w)| w * sinc_squared(u - p)).sum() };
            let grid = (0..5000).map(|i| -3.0 + f64::from(i) * 0.0092);
            let top = grid.max_by(|a, b| f(*a).total_cmp(&f(*b))).expect("points");
            // The grid is off by up to half its step.
            let holds = |cell: &Cell| cell.low - 0.01 <= top && top <= cell.high + 0.01;
            prop_assert!(cells(&places).iter().any(holds), "maximum at {}", top);
            for cell in cells(&places) {
                prop_assert!(cell.low <= cell.at && cell.at <= cell.high && cell.share > 0.733 && cell.high - cell.low <= SPACING + 1e-12);
            }
        }
    }
}
