//! Where no path is inside the limits: chains of diffractions from corner to corner.
//!
//! For every pair of a first corner, seen by the transmitter, and a last one, seen by the
//! receiver, the strongest chain of d mutually visible corners is a path, with the smallest d
//! that connects the two. Strength is the product of all diffraction coefficients over the square
//! root of the product of all leg lengths: symmetric, so that the reverse link has the same
//! chains, and multiplicative from corner to corner, so that dynamic programming finds the best.
//! What a turn from one neighbour to another costs at a corner is computed once a map.

use std::sync::OnceLock;

use multiversion::multiversion;
use num_complex::Complex64;
use smallvec::SmallVec;

use crate::corner_graph::{CornerGraph, turn};
use crate::error::TraceError;
use crate::legs::{Corners, Leg};
use crate::link::Link;
use crate::map::Map;
use crate::path::{Interaction, InteractionKind, Interactions, PathRecord};
use crate::terminal::{Receiver, Transmitter};

/// For the rounding of strengths and gains, and for the tie-breaks of corners.
const ROUNDING: f64 = 1.0 + 1e-6;

/// The best chains of one transmitter, made layer by layer when links ask for them.
#[derive(Debug, Clone)]
pub(crate) struct Chains {
    /// The transmitter's direct legs: its first corners.
    starts: Vec<Leg>,
    /// `layers[d - 2]`: chains of d corners.
    layers: Vec<OnceLock<Layer>>,
}

/// Best chains by last edge and start: `strength[edge * starts + start]`, zero for none.
#[derive(Debug, Clone)]
struct Layer {
    strength: Vec<f64>,
    /// By last edge, over all starts.
    strongest: Vec<f64>,
    /// The edge before.
    before: Vec<u32>,
}

impl Layer {
    fn empty(len: usize) -> Self {
        Self {
            strength: vec![0.0; len],
            strongest: Vec::new(),
            before: vec![u32::MAX; len],
        }
    }
}

impl Chains {
    fn new(tx: &Transmitter, longest: usize) -> Self {
        Self {
            starts: direct(tx.legs.all()).copied().collect(),
            layers: (2..=longest).map(|_| OnceLock::new()).collect(),
        }
    }

    /// Memory that chains of up to `d` corners take.
    fn bytes(&self, graph: &CornerGraph, d: usize) -> usize {
        let states = self.starts.len().saturating_mul(graph.edges.len());
        let layer = states.saturating_mul(size_of::<f64>() + size_of::<u32>());
        layer.saturating_mul(d - 1)
    }

    /// Chains of `d` corners, two or more.
    fn layer(&self, graph: &CornerGraph, corners: &Corners, d: usize) -> &Layer {
        self.layers[d - 2].get_or_init(|| {
            let n = self.starts.len();
            let mut layer = if d == 2 {
                self.first_layer(graph, corners)
            } else {
                relax(graph, self.layer(graph, corners, d - 1), n)
            };
            let rows = layer.strength.chunks_exact(n);
            layer.strongest = rows
                .map(|row| row.iter().copied().fold(0.0, f64::max))
                .collect();
            layer
        })
    }

    fn first_layer(&self, graph: &CornerGraph, corners: &Corners) -> Layer {
        let n = self.starts.len();
        let mut layer = Layer::empty(n * graph.edges.len());
        for (s, start) in self.starts.iter().enumerate() {
            let wedge = &corners.wedges[start.corner as usize];
            for e in graph.leaving(start.corner) {
                let ray = &graph.edges[e].ray;
                layer.strength[e * n + s] = start.strength * turn(wedge, &start.ray, ray);
            }
        }
        layer
    }
}

impl Chains {
    /// The corners of the chain of `d` that starts with `start` and ends over `edge`.
    fn sequence(
        &self,
        graph: &CornerGraph,
        d: usize,
        start: usize,
        edge: u32,
        last: u32,
    ) -> SmallVec<[u32; 4]> {
        let mut sequence = SmallVec::from_slice(&[last]);
        let mut edge = edge as usize;
        for layer in self.layers[..=d - 2].iter().rev() {
            sequence.push(graph.edges[graph.edges[edge].reverse as usize].to);
            let layer = layer.get().expect("a layer is made after those before it");
            edge = layer.before[edge * self.starts.len() + start] as usize;
        }
        sequence.reverse();
        sequence
    }
}

/// One more corner: the best continuation over each edge.
fn relax(graph: &CornerGraph, old: &Layer, starts: usize) -> Layer {
    let mut new = Layer::empty(old.strength.len());
    let row = |edge: usize| edge * starts..(edge + 1) * starts;
    for c in 0..graph.corner_count() {
        let edges = graph.leaving(c as u32);
        for (i, back) in edges.clone().enumerate() {
            let arriving = graph.edges[back].reverse;
            let so_far = &old.strength[row(arriving as usize)];
            if so_far.iter().all(|&v| v == 0.0) {
                continue;
            }
            for (leaving, &turn) in edges.clone().zip(graph.turns_from(c, i)) {
                if leaving == back {
                    continue;
                }
                let strength = &mut new.strength[row(leaving)];
                let before = &mut new.before[row(leaving)];
                for ((value, best), from) in so_far.iter().zip(strength).zip(before) {
                    let value = value * turn;
                    if value > *best {
                        *best = value;
                        *from = arriving;
                    }
                }
            }
        }
    }
    new
}

/// What a receiver asks of the chains that arrive at the corners it sees: every edge into each,
/// with the turn towards the receiver.
pub(crate) type Arrivals = Vec<(Leg, Vec<(u32, f64)>)>;

fn arrivals(graph: &CornerGraph, corners: &Corners, rx: &Receiver) -> Arrivals {
    direct(rx.legs.all())
        .map(|&last| {
            let wedge = &corners.wedges[last.corner as usize];
            let edges = graph.leaving(last.corner).map(|back| {
                let edge = &graph.edges[back];
                (edge.reverse, wedge.coefficient(&edge.ray, &last.ray).norm())
            });
            (last, edges.collect())
        })
        .collect()
}

fn direct(legs: &[Leg]) -> impl Iterator<Item = &Leg> {
    legs.iter().filter(|leg| leg.reflections == 0)
}

/// Adds the chains with the fewest diffractions beyond the limit that connect the two.
///
/// # Errors
/// [`TraceError::TooManyChains`] before more memory than allowed is taken.
pub(crate) fn fall_back(
    map: &Map<'_>,
    tx: &Transmitter,
    rx: &Receiver,
    link: &mut Link,
) -> Result<(), TraceError> {
    let (Some(graph), longest) = (&map.graph, map.config.max_fallback_diffractions) else {
        return Ok(());
    };
    if direct(tx.legs.all()).next().is_none() || direct(rx.legs.all()).next().is_none() {
        return Ok(());
    }
    let first = map.config.max_diffractions + 1;
    if first == 1 {
        single(map, tx, rx, link);
        if !link.paths.is_empty() {
            link.fallback_diffractions = Some(1);
            return Ok(());
        }
    }
    if longest < 2 {
        return Ok(());
    }
    let chains = tx.chains.get_or_init(|| Chains::new(tx, longest));
    let limit = map.config.max_wave_bytes;
    for d in first.max(2)..=longest {
        if chains.bytes(graph, d) > limit {
            return Err(TraceError::TooManyChains {
                position: tx.position,
                diffractions: d,
                limit,
            });
        }
        join_chains(map, graph, chains, d, (tx, rx), link);
        if !link.paths.is_empty() {
            link.fallback_diffractions = Some(d);
            return Ok(());
        }
    }
    Ok(())
}

/// Chains of one corner: those both ends see.
fn single(map: &Map<'_>, tx: &Transmitter, rx: &Receiver, link: &mut Link) {
    for last in direct(rx.legs.all()) {
        for start in direct(tx.legs.to(last.corner)) {
            let path = record(map, &[start.corner], (start, last), (tx, rx));
            link.paths.push(path);
        }
    }
    cut_chains(map, link);
}

/// The best chain of `d` corners from each first to each last corner.
fn join_chains(
    map: &Map<'_>,
    graph: &CornerGraph,
    chains: &Chains,
    d: usize,
    (tx, rx): (&Transmitter, &Receiver),
    link: &mut Link,
) {
    let corners = &map.corners;
    let n = chains.starts.len();
    let layer = chains.layer(graph, corners, d);
    let arrivals = rx.arrivals.get_or_init(|| arrivals(graph, corners, rx));
    // No path is shorter than the line.
    let distance_m = tx.place.distance(rx.place);
    let at_most = map.friis.amplitude(1.0) / distance_m.sqrt() * ROUNDING;
    let bound = |last: &Leg, &(edge, turn): &(u32, f64)| {
        at_most * layer.strongest[edge as usize] * turn * last.strength
    };
    let chain = |i: usize, s: usize| {
        let (last, edges) = &arrivals[i];
        let strongest = |best: (f64, u32), &(edge, turn): &(u32, f64)| {
            let value = layer.strength[edge as usize * n + s] * turn;
            if value > best.0 { (value, edge) } else { best }
        };
        let (_, edge) = edges.iter().fold((0.0, u32::MAX), strongest);
        let sequence = chains.sequence(graph, d, s, edge, last.corner);
        record(map, &sequence, (&chains.starts[s], last), (tx, rx))
    };
    // One promising chain tells what the others have to reach.
    let all = (0..).zip(arrivals);
    let all = all.flat_map(|(i, (last, edges))| edges.iter().map(move |e| (i, bound(last, e), e)));
    let Some((i, most, &(edge, _))) = all.max_by(|p, q| p.1.total_cmp(&q.1)) else {
        return;
    };
    if most == 0.0 {
        return;
    }
    let row = &layer.strength[edge as usize * n..][..n];
    let by_strength = |p: &usize, q: &usize| row[*p].total_cmp(&row[*q]);
    let start = (0..n).max_by(by_strength).unwrap_or(0);
    let mut floor = chain(i, start).power().sqrt() * map.range;
    let mut best: Vec<f64> = Vec::with_capacity(n);
    let mut candidates: Vec<(f64, usize, usize)> = Vec::new();
    for (i, (last, edges)) in arrivals.iter().enumerate() {
        best.clear();
        best.resize(n, 0.0);
        for edge in edges {
            // Where the best of a start is stronger, another edge holds it.
            if bound(last, edge) >= floor {
                let row = &layer.strength[edge.0 as usize * n..][..n];
                raise(&mut best, row, edge.1);
            }
        }
        let connected = best.iter().enumerate().filter(|best| *best.1 > 0.0);
        candidates.extend(connected.map(|(s, value)| (at_most * value * last.strength, i, s)));
    }
    candidates.sort_by(|p, q| q.0.total_cmp(&p.0));
    for (bound, i, s) in candidates {
        if bound < floor {
            break;
        }
        let path = chain(i, s);
        floor = floor.max(path.power().sqrt() * map.range);
        link.paths.push(path);
    }
    cut_chains(map, link);
}

/// Raises each to the value in the row times the turn.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
fn raise(best: &mut [f64], row: &[f64], turn: f64) {
    for (best, &value) in best.iter_mut().zip(row) {
        let value = value * turn;
        *best = if value > *best { value } else { *best };
    }
}

/// Computes the field along a sequence of corners.
fn record(
    map: &Map<'_>,
    sequence: &[u32],
    (start, last): (&Leg, &Leg),
    (tx, rx): (&Transmitter, &Receiver),
) -> PathRecord {
    let wedges = &map.corners.wedges;
    let mut length_m = start.ray.length_m;
    let mut amplitude = Complex64::from(start.strength);
    let mut arriving = start.ray;
    for pair in sequence.windows(2) {
        let (near, far) = (&wedges[pair[0] as usize], &wedges[pair[1] as usize]);
        let leaving = near.ray(far.point);
        amplitude *= near.coefficient(&arriving, &leaving) / leaving.length_m.sqrt();
        length_m += leaving.length_m;
        arriving = far.ray(near.point);
    }
    let wedge = &wedges[last.corner as usize];
    amplitude *= wedge.coefficient(&arriving, &last.ray) * last.strength;
    length_m += last.ray.length_m;
    let gain = map.friis.gain(length_m) * length_m.sqrt() * amplitude;
    let interactions: Interactions = sequence
        .iter()
        .map(|&c| Interaction {
            kind: InteractionKind::Diffraction,
            id: wedges[c as usize].id,
            point: wedges[c as usize].point,
        })
        .collect();
    PathRecord::new(tx.place, rx.place, interactions, length_m, gain)
}

fn cut_chains(map: &Map<'_>, link: &mut Link) {
    let strongest = link.paths.iter().map(PathRecord::power).fold(0.0, f64::max);
    let floor = strongest * map.range * map.range;
    link.paths.retain(|p| p.power() >= floor && p.power() > 0.0);
}
