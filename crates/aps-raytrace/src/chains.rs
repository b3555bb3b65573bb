//! The best chains of diffractions of one transmitter, from corner to corner.
//!
//! For every edge of the graph and every first corner that the transmitter sees, the strongest chain of d corners that ends with the
//! edge: dynamic programming. The strongest over all first corners follows the same recursion, bit for bit, at a fraction of the
//! cost. It tells which edges can matter to a link; the rest is computed for those alone, when the first link asks.

use std::sync::OnceLock;

use smallvec::SmallVec;

use crate::corner_graph::{CornerGraph, turn};
use crate::legs::{Corners, Leg};

/// Marker of a chain that has no edge before its last.
const NO_EDGE: u32 = u32::MAX;

/// Edges into each corner that a receiver sees directly, each edge with the magnitude of D for the turn towards the receiver.
pub(crate) type Arrivals = Vec<(Leg, Vec<(u32, f64)>)>;

/// The best chains of one transmitter, made when links ask for them.
#[derive(Debug, Clone)]
pub(crate) struct Chains {
    /// The transmitter's direct legs: its first corners.
    pub starts: Vec<Leg>,
    /// Index of the start at each corner.
    start_at: Vec<Option<u32>>,
    /// Chains of d corners in `layers[d - 2]`.
    layers: Vec<OnceLock<Layer>>,
}

/// Best chains by last edge.
#[derive(Debug, Clone)]
struct Layer {
    /// Strength of the best chain over all starts; zero if there is none.
    strongest: Vec<f64>,
    rows: Vec<OnceLock<Row>>,
}

/// Best chains that end with one edge, by start.
#[derive(Debug, Clone)]
struct Row {
    /// Strength of the best chain; zero if there is none.
    strength: Vec<f64>,
    /// The edge before.
    before: Vec<u32>,
}

/// Graph and corners from which chains are made: prepared once a map.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Graph<'g> {
    pub graph: &'g CornerGraph,
    pub corners: &'g Corners,
}

impl Chains {
    /// Creates empty chains of up to `longest` corners.
    pub fn new(of: Graph<'_>, starts: Vec<Leg>, longest: usize) -> Self {
        let mut start_at = vec![None; of.corners.wedges.len()];
        for (i, start) in (0..).zip(&starts) {
            start_at[start.corner as usize] = Some(i);
        }
        Self {
            starts,
            start_at,
            layers: (2..=longest).map(|_| OnceLock::new()).collect(),
        }
    }

    /// Memory that chains of up to `d` corners may take.
    pub fn bytes(&self, graph: &CornerGraph, d: usize) -> usize {
        let state = size_of::<f64>() + size_of::<u32>();
        let edge = size_of::<f64>() + size_of::<OnceLock<Row>>();
        let of_edge = self.starts.len().saturating_mul(state) + edge;
        of_edge
            .saturating_mul(graph.edges.len())
            .saturating_mul(d - 1)
    }

    fn layer(&self, of: Graph<'_>, d: usize) -> &Layer {
        self.layers[d - 2].get_or_init(|| {
            let strongest = if d == 2 {
                self.first_edges(of)
            } else {
                relax(of.graph, self.strongest(of, d - 1))
            };
            Layer {
                rows: strongest.iter().map(|_| OnceLock::new()).collect(),
                strongest,
            }
        })
    }

    /// Strength of the strongest chain of `d` corners by last edge; zero if there is none.
    pub fn strongest(&self, of: Graph<'_>, d: usize) -> &[f64] {
        &self.layer(of, d).strongest
    }

    /// Strengths of the chains of `d` corners that end with an edge, by start.
    pub fn strengths(&self, of: Graph<'_>, d: usize, edge: u32) -> &[f64] {
        &self.row(of, d, edge).strength
    }

    fn first_edges(&self, of: Graph<'_>) -> Vec<f64> {
        let mut strengths = vec![0.0; of.graph.edges.len()];
        for start in &self.starts {
            let wedge = &of.corners.wedges[start.corner as usize];
            for e in of.graph.leaving(start.corner) {
                let ray = &of.graph.edges[e].ray;
                strengths[e] = start.strength * turn(wedge, &start.ray, ray);
            }
        }
        strengths
    }

    fn row(&self, of: Graph<'_>, d: usize, edge: u32) -> &Row {
        self.layer(of, d).rows[edge as usize].get_or_init(|| {
            let edges = &of.graph.edges;
            let corner = edges[edges[edge as usize].reverse as usize].to;
            let mut row = Row {
                strength: vec![0.0; self.starts.len()],
                before: vec![NO_EDGE; self.starts.len()],
            };
            if d == 2 {
                if let Some(start) = self.start_at[corner as usize] {
                    row.strength[start as usize] = self.strongest(of, d)[edge as usize];
                }
                return row;
            }
            let so_far = self.strongest(of, d - 1);
            let leaving = of.graph.leaving(corner);
            let place = edge as usize - leaving.start;
            for (i, back) in leaving.enumerate() {
                let arriving = edges[back].reverse;
                if back == edge as usize || so_far[arriving as usize] == 0.0 {
                    continue;
                }
                let turn = of.graph.turns_from(corner as usize, i)[place];
                if d == 3 {
                    // Only the start at the corner before has come along this edge.
                    let start = self.start_at[edges[back].to as usize];
                    let start = start.expect("it has a strength") as usize;
                    row.raise(start, so_far[arriving as usize] * turn, arriving);
                } else {
                    let before = self.strengths(of, d - 1, arriving);
                    for (start, value) in before.iter().enumerate() {
                        row.raise(start, value * turn, arriving);
                    }
                }
            }
            row
        })
    }

    /// The corners of the chain of `d` that starts with `start` and ends over `edge`.
    pub fn sequence(
        &self,
        of: Graph<'_>,
        d: usize,
        start: usize,
        edge: u32,
        last: u32,
    ) -> SmallVec<[u32; 4]> {
        let mut sequence = SmallVec::from_slice(&[last]);
        let mut edge = edge;
        for d in (2..=d).rev() {
            let back = of.graph.edges[edge as usize].reverse;
            sequence.push(of.graph.edges[back as usize].to);
            edge = self.row(of, d, edge).before[start];
        }
        sequence.reverse();
        sequence
    }
}

impl Row {
    fn raise(&mut self, start: usize, value: f64, before: u32) {
        if value > self.strength[start] {
            self.strength[start] = value;
            self.before[start] = before;
        }
    }
}

/// Extends chains by one corner: the strongest continuation over each edge.
fn relax(graph: &CornerGraph, old: &[f64]) -> Vec<f64> {
    let mut new = vec![0.0; old.len()];
    for c in 0..graph.corner_count() {
        let edges = graph.leaving(c as u32);
        for (i, back) in edges.clone().enumerate() {
            let so_far = old[graph.edges[back].reverse as usize];
            if so_far == 0.0 {
                continue;
            }
            let kept = new[back];
            for (best, turn) in new[edges.clone()].iter_mut().zip(graph.turns_from(c, i)) {
                *best = f64::max(*best, so_far * turn);
            }
            // Nothing turns back.
            new[back] = kept;
        }
    }
    new
}
