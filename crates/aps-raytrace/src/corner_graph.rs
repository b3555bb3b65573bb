//! The graph of mutually visible corners: done once a map, for chains of diffractions.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::error::ConfigError;
use crate::legs::{Corners, NEAREST_M};
use crate::ray::Ray;
use crate::scene::Scene;
use crate::wedge::Wedge;

/// A corner as seen from another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edge {
    pub to: u32,
    /// The edge back.
    pub reverse: u32,
    /// Ray at the near corner, towards the far one.
    pub ray: Ray,
}

/// Pairs of mutually visible corners, and the turns between them.
#[derive(Debug, Clone)]
pub(crate) struct CornerGraph {
    /// Edges by the corner they leave.
    pub edges: Vec<Edge>,
    /// First edge of each corner, and the end.
    first: Vec<u32>,
    /// Factors of the turns between every two edges of a corner, row by row: |D| over the square root of the second edge's length.
    turns: Vec<f64>,
    /// First turn of each corner.
    first_turn: Vec<usize>,
}

impl CornerGraph {
    /// Costs a few signs for every pair of corners, a visibility test for every pair of which neither
    /// lies behind the other's walls, and a coefficient for every turn; spread over the threads.
    ///
    /// # Errors
    /// [`ConfigError::TooManyWaves`] before more than `max_bytes` are taken.
    pub fn new(scene: &Scene, corners: &Corners, max_bytes: usize) -> Result<Self, ConfigError> {
        let wedges = &corners.wedges;
        let too_many = || ConfigError::TooManyWaves {
            what: "pairs and turns of corners that see each other",
            setting: "max_fallback_diffractions",
            limit: max_bytes,
        };
        let most_pairs = max_bytes / (2 * size_of::<Edge>());
        let pairs = AtomicUsize::new(0);
        // Visibility is decided alike both ways: test each pair once.
        let later: Vec<Vec<u32>> = wedges
            .par_iter()
            .enumerate()
            .map(|(from, near)| {
                let is_seen = |far: &Wedge| {
                    near.point.distance(far.point) >= NEAREST_M
                        && !near.is_inside(far.point)
                        && !far.is_inside(near.point)
                        && !scene.is_blocked(near.point, far.point)
                };
                let others = (from + 1..wedges.len()).filter(|&to| is_seen(&wedges[to]));
                // The order of counting does not change if there are too many pairs.
                let counted =
                    others.take_while(|_| pairs.fetch_add(1, Ordering::Relaxed) < most_pairs);
                counted.map(|to| to as u32).collect()
            })
            .collect();
        if pairs.into_inner() > most_pairs {
            return Err(too_many());
        }
        let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); wedges.len()];
        for (from, seen) in later.iter().enumerate() {
            for &to in seen {
                neighbours[from].push(to);
                neighbours[to as usize].push(from as u32);
            }
        }
        let mut first = vec![0_u32];
        for seen in &mut neighbours {
            seen.sort_unstable();
            first.push(first[first.len() - 1] + seen.len() as u32);
        }
        let squares = neighbours.iter().map(|seen| seen.len().pow(2));
        let turns = squares.fold(0, usize::saturating_add);
        let edges = neighbours.iter().map(Vec::len).sum::<usize>();
        if turns.saturating_mul(size_of::<f64>()) > max_bytes - edges * size_of::<Edge>() {
            return Err(too_many());
        }
        let edges: Vec<Edge> = (0_u32..)
            .zip(&neighbours)
            .flat_map(|(from, seen)| seen.iter().map(move |&to| (from, to)))
            .map(|(from, to)| {
                let back = neighbours[to as usize].binary_search(&from);
                let back = back.expect("visibility is mutual") as u32;
                Edge {
                    to,
                    reverse: first[to as usize] + back,
                    ray: wedges[from as usize].ray(wedges[to as usize].point),
                }
            })
            .collect();
        let mut turns = vec![0.0; turns];
        let (mut first_turn, mut count, mut rest) = (Vec::new(), 0, &mut turns[..]);
        let mut by_corner = Vec::with_capacity(wedges.len());
        for seen in &neighbours {
            let (own, others) = rest.split_at_mut(seen.len().pow(2));
            first_turn.push(count);
            count += own.len();
            by_corner.push(own);
            rest = others;
        }
        let by_corner = by_corner.into_par_iter().zip(wedges).enumerate();
        by_corner.for_each(|(c, (turns, wedge))| {
            let edges = &edges[first[c] as usize..first[c + 1] as usize];
            let pairs = edges.iter().flat_map(|p| edges.iter().map(move |q| (p, q)));
            let tie_break = tie_break(wedge.id);
            for (out, (p, q)) in turns.iter_mut().zip(pairs) {
                *out = turn(wedge, &p.ray, &q.ray) * tie_break;
            }
        });
        Ok(Self {
            edges,
            first,
            turns,
            first_turn,
        })
    }

    /// Edges of a corner.
    pub fn leaving(&self, corner: u32) -> std::ops::Range<usize> {
        self.first[corner as usize] as usize..self.first[corner as usize + 1] as usize
    }

    /// Number of corners.
    pub fn corner_count(&self) -> usize {
        self.first.len() - 1
    }

    /// Turns at corner `c` from its `i`-th edge to all of its edges.
    pub fn turns_from(&self, c: usize, i: usize) -> &[f64] {
        let degree = self.leaving(c as u32).len();
        &self.turns[self.first_turn[c] + i * degree..][..degree]
    }
}

/// A factor between 1 and 1 + 1e-9, each corner its own. In a symmetric scene two chains can be
/// equally strong; rounding would then choose one of them this way and the other on the way back.
/// The product of these factors over a chain is the same both ways.
fn tie_break(corner: u32) -> f64 {
    // Murmur3's finaliser: sums of neighbouring ids must not come out equal.
    let mut h = corner ^ 0x9e37_79b9;
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^= h >> 16;
    1.0 + f64::from(h) * 2.0_f64.powi(-62)
}

/// Factor of a chain's strength for a turn from one ray to another and the way along the other: |D| / sqrt(length).
pub(crate) fn turn(wedge: &Wedge, arriving: &Ray, leaving: &Ray) -> f64 {
    (wedge.coefficient(arriving, leaving).norm_sqr() / leaving.length_m).sqrt()
}
