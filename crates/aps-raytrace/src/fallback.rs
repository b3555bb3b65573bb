//! Chains of diffractions from corner to corner, for links without a path inside the limits.
//!
//! For every pair of a first corner, seen by the transmitter, and a last one, seen by the
//! receiver, the strongest chain of d mutually visible corners is a path, with the smallest d
//! that connects the two. Strength is the product of all diffraction coefficients over the square
//! root of the product of all leg lengths: symmetric, so that the reverse link has the same
//! chains, and multiplicative from corner to corner, so that dynamic programming finds the best.
//! The factor of each turn from one neighbour to another at a corner is computed once a map.

use multiversion::multiversion;
use num_complex::Complex64;

use crate::chains::{Arrivals, Chains, Graph};
use crate::error::TraceError;
use crate::legs::Leg;
use crate::link::Link;
use crate::map::Map;
use crate::path::{Interaction, InteractionKind, Interactions, PathRecord};
use crate::terminal::{Receiver, Transmitter};

/// Factor for the rounding of strengths and gains, and for the tie-breaks of corners.
const ROUNDING: f64 = 1.0 + 1e-6;

fn arrivals(of: Graph<'_>, rx: &Receiver) -> Arrivals {
    direct(rx.legs.all())
        .map(|&last| {
            let wedge = &of.corners.wedges[last.corner as usize];
            let edges = of.graph.leaving(last.corner).map(|back| {
                let edge = &of.graph.edges[back];
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
    let first = map.config.diffraction_limit() + 1;
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
    let of = Graph {
        graph,
        corners: &map.corners,
    };
    let chains = tx.chains.get_or_init(|| {
        let starts = direct(tx.legs.all()).copied().collect();
        Chains::new(of, starts, longest)
    });
    let limit = map.config.max_wave_bytes;
    for d in first.max(2)..=longest {
        if chains.bytes(graph, d) > limit {
            return Err(TraceError::TooManyChains {
                position: tx.position,
                diffractions: d,
                limit,
            });
        }
        join_chains(map, of, chains, d, (tx, rx), link);
        if !link.paths.is_empty() {
            link.fallback_diffractions = Some(d);
            return Ok(());
        }
    }
    Ok(())
}

/// Adds the chains of one corner: those both ends see.
fn single(map: &Map<'_>, tx: &Transmitter, rx: &Receiver, link: &mut Link) {
    for last in direct(rx.legs.all()) {
        for start in direct(tx.legs.to(last.corner)) {
            let path = record(map, &[start.corner], (start, last), (tx, rx));
            link.paths.push(path);
        }
    }
    cut_chains(map, link);
}

/// Adds the best chain of `d` corners from each first to each last corner.
fn join_chains(
    map: &Map<'_>,
    of: Graph<'_>,
    chains: &Chains,
    d: usize,
    (tx, rx): (&Transmitter, &Receiver),
    link: &mut Link,
) {
    let strongest = chains.strongest(of, d);
    let arrivals = rx.arrivals.get_or_init(|| arrivals(of, rx));
    // No path is shorter than the line.
    let distance_m = tx.place.distance(rx.place);
    let at_most = map.friis.amplitude(1.0) / distance_m.sqrt() * ROUNDING;
    // The strength at a last corner, and the gain over it.
    let value = |&(edge, turn): &(u32, f64)| strongest[edge as usize] * turn;
    let over = |last: &Leg| at_most * last.strength;
    let chain = |i: usize, start: usize, least: f64| {
        let (last, edges) = &arrivals[i];
        let strong = edges.iter().filter(|edge| value(edge) >= least);
        let (_, edge) = strong.fold((0.0, u32::MAX), |best, &(edge, turn)| {
            let value = chains.strengths(of, d, edge)[start] * turn;
            if value > best.0 { (value, edge) } else { best }
        });
        let sequence = chains.sequence(of, d, start, edge, last.corner);
        record(map, &sequence, (&chains.starts[start], last), (tx, rx))
    };
    // One promising chain sets the strength that the others have to reach.
    let all = (0..).zip(arrivals);
    let all = all.flat_map(|(i, (_, edges))| edges.iter().map(move |edge| (i, edge)));
    let bound = |(i, edge): (usize, &(u32, f64))| value(edge) * over(&arrivals[i].0);
    let (mut most, mut best) = (0.0, None);
    for at in all {
        let bound = bound(at);
        if bound > most {
            (most, best) = (bound, Some(at));
        }
    }
    let Some((i, edge)) = best else {
        return;
    };
    let row = chains.strengths(of, d, edge.0);
    let by_strength = |p: &usize, q: &usize| row[*p].total_cmp(&row[*q]);
    let start = (0..row.len()).max_by(by_strength).unwrap_or(0);
    let mut floor = chain(i, start, value(edge)).power().sqrt() * map.range;
    let mut best: Vec<f64> = Vec::new();
    let mut candidates: Vec<(f64, usize, usize, f64)> = Vec::new();
    for (i, (last, edges)) in arrivals.iter().enumerate() {
        best.clear();
        best.resize(chains.starts.len(), 0.0);
        for edge in edges {
            // Where the best of a start is stronger, another edge holds it.
            let most = value(edge);
            if most > 0.0 && most * over(last) >= floor {
                raise(&mut best, chains.strengths(of, d, edge.0), edge.1);
            }
        }
        for (start, &value) in best.iter().enumerate() {
            if value > 0.0 {
                candidates.push((value * over(last), i, start, value));
            }
        }
    }
    candidates.sort_by(|p, q| q.0.total_cmp(&p.0));
    for (bound, i, start, value) in candidates {
        if bound < floor {
            break;
        }
        let path = chain(i, start, value);
        floor = floor.max(path.power().sqrt() * map.range);
        link.paths.push(path);
    }
    cut_chains(map, link);
}

/// Raises each of the best values to the one in the row times the turn.
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

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use crate::{Footprint, Scene, TraceConfig, Tracer};

    #[test]
    fn chains_begin_with_the_fewest_corners_that_no_path_may_have() {
        let house = [(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)].map(DVec2::from);
        let scene = Scene::new(&[Footprint::new(house)], None).unwrap();
        let around_one_corner = [DVec2::new(-5.0, 5.0), DVec2::new(10.0, 15.0)];
        let around_two = [DVec2::new(-5.0, 5.0), DVec2::new(25.0, 5.0)];
        let corners = |max_diffractions, max_interactions, [tx, rx]: [DVec2; 2]| {
            let config = TraceConfig {
                max_reflections: 0,
                max_diffractions,
                max_interactions,
                max_fallback_diffractions: 4,
                ..TraceConfig::default()
            };
            let tracer = Tracer::new(&scene, config).unwrap();
            tracer.trace(tx, rx).unwrap().fallback_diffractions
        };
        for limits in [(0, 0), (1, 0), (4, 0)] {
            assert_eq!(
                corners(limits.0, limits.1, around_one_corner),
                Some(1),
                "{limits:?}"
            );
        }
        assert_eq!(corners(1, 1, around_one_corner), None);
        assert_eq!(corners(2, 1, around_two), Some(2));
    }
}
