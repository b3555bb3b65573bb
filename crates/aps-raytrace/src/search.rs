//! The search for the diffracted paths of a link.
//!
//! Every pair of a front of the transmitter and a leg of the receiver at one corner is a path. Most are too weak to count. A bound of
//! each one's amplitude costs a few nanoseconds, and one product bounds all that take the legs of one block; only those whose bound
//! is within the dynamic range of the strongest path known are computed, the most promising first. Nothing is left out but by a bound
//! that is proven, so the paths that remain are the same as if all were computed.

mod assemble;
mod more_corners;

use num_complex::Complex64;

use crate::fronts::{BlockFronts, FrontId, Sources};
use crate::legs::{AtCorner, Legs};
use crate::link::{Link, Omitted};
use crate::map::Map;
use crate::path::{Interactions, PathRecord};
use crate::terminal::{Receiver, Transmitter};
use more_corners::{Crossing, Part};

/// Factor that lowers the floor with which bounds are compared: far more than the rounding of bounds and amplitudes.
const SLACK: f64 = 1.0 - 1e-9;

/// A path that may be strong enough.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    /// Upper bound of its amplitude.
    bound: f64,
    front: FrontId,
    /// The last leg, one of the receiver's.
    leg: u32,
}

/// A path that is strong enough as far as known, not yet assembled.
#[derive(Debug, Clone, Copy)]
struct Found {
    front: FrontId,
    leg: u32,
    length_m: f64,
    gain: Complex64,
}

/// Memory of the search, to be used again.
#[derive(Debug, Clone, Default)]
pub(crate) struct Search {
    /// Corners that both ends reach.
    common: Vec<(AtCorner, AtCorner)>,
    candidates: Vec<Candidate>,
    /// Blocks of fronts, with the corner where they end, by its place among those that the receiver sees.
    blocks: Vec<(u32, BlockFronts)>,
    crossings: Vec<Crossing>,
    parts: Vec<Part>,
    found: Vec<Found>,
    reflected: Vec<PathRecord>,
    path: Interactions,
    /// Empty ones with room for many interactions, of former paths.
    spare: Vec<Interactions>,
}

/// One search.
struct Ends<'t> {
    map: &'t Map<'t>,
    tx: &'t Transmitter,
    rx: &'t Receiver,
    sources: Sources<'t>,
    /// Factor that turns the strengths of a front and a last step into an upper bound: no path is shorter than the line.
    of_strengths: f64,
    /// Amplitude below which a path is out of the dynamic range, as far as known.
    floor: f64,
    /// Pairs computed.
    computed: usize,
    omitted: Omitted,
}

/// Adds the diffracted paths to the others of a link, and applies the dynamic range to all.
pub(crate) fn diffract(map: &Map<'_>, tx: &Transmitter, rx: &Receiver, link: &mut Link) {
    let mut search = std::mem::take(&mut link.search);
    search.found.clear();
    let distance_m = tx.place.distance(rx.place);
    let mut ends = Ends {
        map,
        tx,
        rx,
        sources: Sources {
            corners: &map.corners,
            between: map.between.as_ref(),
            legs: &tx.legs,
        },
        of_strengths: map.friis.amplitude(1.0) / (distance_m.sqrt() * SLACK),
        floor: 0.0,
        computed: 0,
        omitted: Omitted::default(),
    };
    let strongest = link.paths.iter().map(PathRecord::power).fold(0.0, f64::max);
    ends.raise_floor(strongest.sqrt());
    ends.over_one_corner(&mut search);
    ends.compute(&mut search);
    if map.between.is_some() {
        ends.over_more_corners(&mut search);
        ends.compute(&mut search);
    }
    link.omitted = ends.omitted;
    link.omitted.by_bound = ends.paths_within_limits() - ends.computed;
    ends.cut(&mut search, link);
    link.search = search;
}

impl Ends<'_> {
    fn raise_floor(&mut self, amplitude: f64) {
        self.floor = self.floor.max(amplitude * self.map.range * SLACK);
    }

    /// Counts the pairs of a front and a leg of the receiver that make a path within the limits.
    fn paths_within_limits(&self) -> usize {
        let limits = self.map.config.limits();
        let fronts = &self.tx.fronts;
        let counts = self.rx.legs.counts().iter();
        let paths = counts.map(|of| of.legs * fronts.paths(of.corner, of.reflections, &limits));
        paths.sum()
    }

    /// Candidates over one corner.
    fn over_one_corner(&mut self, search: &mut Search) {
        search.candidates.clear();
        search.common.clear();
        let [mut tx, mut rx] = [&self.tx.legs, &self.rx.legs].map(Legs::at_corners);
        while let ([p, tx_rest @ ..], [q, rx_rest @ ..]) = (tx, rx) {
            if p.corner == q.corner {
                search.common.push((p.clone(), q.clone()));
            }
            if p.corner <= q.corner {
                tx = tx_rest;
            }
            if q.corner <= p.corner {
                rx = rx_rest;
            }
        }
        if self.floor == 0.0 && self.map.range > 0.0 {
            let product = |(p, q): &(AtCorner, AtCorner)| p.strength.max * q.strength.max;
            let common = search.common.iter();
            let best = common.max_by(|p, q| product(p).total_cmp(&product(q)));
            if let Some((p, q)) = best {
                self.over_corner(p, q, &mut search.candidates);
                self.raise_floor_by(&mut search.candidates);
            }
        }
        for (p, q) in &search.common {
            self.over_corner(p, q, &mut search.candidates);
        }
    }

    /// Candidates over one corner from those legs of the transmitter to those of the receiver.
    fn over_corner(&mut self, tx: &AtCorner, rx: &AtCorner, candidates: &mut Vec<Candidate>) {
        let limits = self.map.config.limits();
        let spread = self.map.friis.amplitude(1.0);
        // |D| is at most 2 sqrt(L), next to the boundaries: no path is stronger than if there were no corner.
        let (before, after) = (tx.strength, rx.strength);
        if spread * f64::from(before.max) * f64::from(after.max) < self.floor {
            self.omit(spread, f64::from(before.power) * f64::from(after.power));
            return;
        }
        let wedge = &self.map.corners.wedges[rx.corner as usize].bound;
        for (i, last) in rx.legs.clone().zip(self.rx.legs.summaries(rx.legs.clone())) {
            for (j, leg) in tx.legs.clone().zip(self.tx.legs.summaries(tx.legs.clone())) {
                if !limits.allow(leg.reflections + last.reflections, 1) {
                    continue;
                }
                let (a, b) = (leg.length_m, last.length_m);
                let length_m = a + b;
                let strength = spread * leg.strength * last.strength;
                let square = 4.0 * (a * b / length_m) / length_m * (strength * strength);
                if square < self.floor * self.floor {
                    self.omitted.power += square;
                    continue;
                }
                let direction = &self.tx.fronts.own()[j as usize];
                let bound = wedge.of(self.rx.steps.own(i as usize), direction);
                let candidate = Candidate {
                    bound: strength * bound / length_m.sqrt(),
                    front: FrontId::own(j),
                    leg: i,
                };
                self.consider(candidate, candidates);
            }
        }
    }

    /// Computes the most promising of candidates to learn a floor from it, and drops them all.
    fn raise_floor_by(&mut self, candidates: &mut Vec<Candidate>) {
        let by_bound = |p: &&Candidate, q: &&Candidate| p.bound.total_cmp(&q.bound);
        if let Some(best) = candidates.iter().max_by(by_bound) {
            let gain = self.found(best).gain;
            self.raise_floor(gain.norm_sqr().sqrt());
        }
        candidates.clear();
    }

    /// Leaves out paths of so much power over an amplitude squared.
    fn omit(&mut self, amplitude: f64, power: f64) {
        self.omitted.power += amplitude * amplitude * power;
    }

    fn consider(&mut self, candidate: Candidate, candidates: &mut Vec<Candidate>) {
        if candidate.bound < self.floor {
            self.omitted.power += candidate.bound * candidate.bound;
        } else {
            candidates.push(candidate);
        }
    }

    /// Computes the candidates, the most promising first, until none of the others can reach the floor.
    fn compute(&mut self, search: &mut Search) {
        if self.map.range > 0.0 {
            let descending = |p: &Candidate, q: &Candidate| q.bound.total_cmp(&p.bound);
            search.candidates.sort_unstable_by(descending);
        }
        for candidate in &search.candidates {
            if candidate.bound < self.floor {
                self.omitted.power += candidate.bound * candidate.bound;
                continue;
            }
            self.computed += 1;
            let found = self.found(candidate);
            // Not norm(): gains are far from the ends of the range that hypot guards.
            let magnitude = found.gain.norm_sqr().sqrt();
            if magnitude < self.floor {
                self.omitted.by_gain += 1;
                self.omitted.power += magnitude * magnitude;
            } else {
                self.raise_floor(magnitude);
                search.found.push(found);
            }
        }
    }

    /// Computes the gain of a candidate.
    fn found(&self, candidate: &Candidate) -> Found {
        let &Candidate { front, leg: i, .. } = candidate;
        let (fronts, sources) = (&self.tx.fronts, &self.sources);
        let leg = &self.rx.legs.all()[i as usize];
        let length_m = fronts.length_m(sources, front) + leg.ray.length_m;
        let wedge = &self.map.corners.wedges[leg.corner as usize];
        let before = fronts.ray(sources, front);
        let amplitude = fronts.amplitude(sources, front);
        let spread = (leg.ray.length_m * length_m).sqrt();
        // The gain is over the length itself: multiply it back.
        let start = self.map.friis.gain(length_m) * length_m;
        let turned = if before.slope == 0.0 {
            start * amplitude.value * wedge.coefficient(before, &leg.ray)
        } else {
            let matrix = wedge.matrix(before, &leg.ray);
            start * (amplitude.value * matrix.value + amplitude.slope * matrix.by_first)
        };
        let gain = turned * leg.coefficient / spread;
        Found {
            front,
            leg: i,
            length_m,
            gain,
        }
    }
}
