//! Samples in single precision, by which cells are left out.

use std::f64::consts::PI;

use multiversion::multiversion;

use super::scratch::{Continuous, POINTS, WIDE, Wide};
use crate::product::{LANES, Lanes};
use crate::pulse::pulses;

/// Pulses farther than this from a sample point are bounded there, not computed.
const NEAR: f64 = 3.0;

/// Weights as `[block][path]`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
pub fn pack_weights(response: &[Lanes], blocks: usize, weights: &mut Vec<Wide>) {
    weights.clear();
    for first in (0..blocks).step_by(2) {
        for row in response.chunks_exact(blocks) {
            let mut wide = [0.0; WIDE];
            for l in 0..LANES {
                wide[l] = row[first][l] as f32;
            }
            if let Some(second) = row.get(first + 1) {
                for l in 0..LANES {
                    wide[LANES + l] = second[l] as f32;
                }
            }
            weights.push(wide);
        }
    }
}

/// Upper bounds of f at the cells' sample points: pulses farther than [`NEAR`] from each of eight
/// points count there with the bound 1/(pi x)^2 at the nearest. And of each column the largest sum
/// without these.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
pub fn sample(search: &mut Continuous) {
    let paths = search.places.len();
    let blocks = search.weights.len() / paths;
    let cells = search.cells.len();
    search.samples.clear();
    search
        .samples
        .resize(cells.next_multiple_of(POINTS) * blocks, [0.0; WIDE]);
    search.least.clear();
    search.least.resize(blocks, [0.0; WIDE]);
    search.near.resize(paths, 0);
    search.far.resize(paths, 0.0);
    let samples = search.samples.chunks_mut(LANES * blocks);
    for (cells, samples) in search.cells.chunks(LANES).zip(samples) {
        let points: Lanes = std::array::from_fn(|l| cells[l.min(cells.len() - 1)].at);
        search.nearest.clear();
        search.nearest.resize(paths, f64::INFINITY);
        for point in points {
            for (nearest, place) in search.nearest.iter_mut().zip(&search.places) {
                let distance = (point - place).abs();
                *nearest = if distance < *nearest {
                    distance
                } else {
                    *nearest
                };
            }
        }
        let mut count = 0;
        for (path, (nearest, far)) in search.nearest.iter().zip(&mut search.far).enumerate() {
            let root = PI * nearest;
            *far = if *nearest < NEAR {
                0.0
            } else {
                1.0 / (root * root)
            } as f32;
            search.near[count] = path;
            count += usize::from(*nearest < NEAR);
        }
        let near = &search.near[..count];
        search.near_places.clear();
        search
            .near_places
            .extend(near.iter().map(|&path| search.places[path]));
        pulses(
            1.0,
            &[points],
            &search.near_places,
            &mut search.pulses[..count],
        );
        search.rows.clear();
        for first in (0..cells.len()).step_by(POINTS) {
            for pulse in &search.pulses[..count] {
                let mut row = [0.0; POINTS];
                for r in 0..POINTS {
                    row[r] = pulse[first + r] as f32;
                }
                search.rows.push(row);
            }
        }
        for (block, weights) in search.weights.chunks_exact(paths).enumerate() {
            let rest = rest(weights, &search.far);
            let mut highest = search.least[block];
            let mut samples = samples[block..].iter_mut().step_by(blocks);
            for first in (0..cells.len()).step_by(POINTS) {
                let rows = &search.rows[first / POINTS * count..][..count];
                for sum in sums(weights, near, rows) {
                    for l in 0..WIDE {
                        highest[l] = if sum[l] > highest[l] {
                            sum[l]
                        } else {
                            highest[l]
                        };
                    }
                    let mut upper = sum;
                    for l in 0..WIDE {
                        upper[l] += rest[l];
                    }
                    if let Some(sample) = samples.next() {
                        *sample = upper;
                    }
                }
            }
            search.least[block] = highest;
        }
    }
}

/// Sum of the weights times the bounds of pulses that are far. It is made in two parts: each addition waits for the one before.
#[inline(always)]
fn rest(weights: &[Wide], far: &[f32]) -> Wide {
    let (mut even, mut odd) = ([0.0; WIDE], [0.0; WIDE]);
    let (weights, last) = weights.as_chunks::<2>();
    let (far, far_last) = far.as_chunks::<2>();
    for (weights, far) in weights.iter().zip(far) {
        for l in 0..WIDE {
            even[l] += far[0] * weights[0][l];
        }
        for l in 0..WIDE {
            odd[l] += far[1] * weights[1][l];
        }
    }
    for (weight, far) in last.iter().zip(far_last) {
        for l in 0..WIDE {
            even[l] += far * weight[l];
        }
    }
    for l in 0..WIDE {
        even[l] += odd[l];
    }
    even
}

#[inline(always)]
fn sums(weights: &[Wide], near: &[usize], rows: &[[f32; POINTS]]) -> [Wide; POINTS] {
    let mut sums = [[0.0; WIDE]; POINTS];
    for (&path, row) in near.iter().zip(rows) {
        let weight = &weights[path];
        for r in 0..POINTS {
            for l in 0..WIDE {
                sums[r][l] += row[r] * weight[l];
            }
        }
    }
    sums
}
