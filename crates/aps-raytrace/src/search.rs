//! The search for the diffracted paths of a link.
//!
//! Every pair of a front of the transmitter and a leg of the receiver at one corner is a path. Most are too weak to count. A bound of
//! each one's amplitude costs a few nanoseconds, and of all whose last waves take the legs of one block a single product; only those whose bound is within
//! the dynamic range of the strongest path known are computed, the most promising first. Nothing is left out but by a bound that is
//! proven, so the paths that remain are the same as if all were computed.

mod assemble;

use num_complex::Complex64;

use crate::fronts::{BlockFronts, FrontId, Sources};
use crate::legs::{AtCorner, Legs};
use crate::link::{Link, Omitted};
use crate::map::Map;
use crate::path::{Interactions, PathRecord};
use crate::strength::RowSum;
use crate::terminal::{Receiver, Transmitter};

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

/// A leg between corners along which some path may reach the floor.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    /// The corner where it ends, by its place among those that the receiver sees.
    at: u32,
    /// The waves at the corner where it begins.
    group: u32,
    /// Among the legs that leave there, and its slot where it arrives.
    leg: u32,
    slot: u32,
    /// The fronts along it.
    before: RowSum,
    /// The last steps that begin with it.
    after: RowSum,
}

/// A leg between corners and a last step.
#[derive(Debug, Clone, Copy)]
struct Part {
    strength: f64,
    length_m: f64,
    reflections: u32,
    leg: u32,
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
    let mut ends = Ends {
        map,
        tx,
        rx,
        sources: Sources {
            corners: &map.corners,
            between: map.between.as_ref(),
            legs: &tx.legs,
        },
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
        counts
            .map(|of| of.legs * fronts.paths(of.corner, of.reflections, &limits))
            .sum()
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
        for (i, last) in rx.legs.clone().zip(self.rx.legs.short(rx.legs.clone())) {
            for (j, leg) in tx.legs.clone().zip(self.tx.legs.short(tx.legs.clone())) {
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

    /// Candidates over several corners.
    fn over_more_corners(&mut self, search: &mut Search) {
        search.candidates.clear();
        if self.floor == 0.0 && self.map.range > 0.0 {
            self.look_for_a_floor(search);
        }
        self.select_blocks(&mut search.blocks);
        self.over_blocks(search);
    }

    /// Picks the blocks of which some path may reach the floor.
    fn select_blocks(&mut self, selected: &mut Vec<(u32, BlockFronts)>) {
        selected.clear();
        let of_square = self.of_strengths().powi(2);
        let floor = self.floor / self.of_strengths();
        let mut power = 0.0;
        let mut omit = |p: f32, q: f64| power += f64::from(p) * q * of_square;
        let steps = &self.rx.steps;
        let fronts = &self.tx.fronts;
        for (i, at) in (0..).zip(steps.corners()) {
            let (arriving, leaving) = (fronts.corner(at.corner), &at.strength);
            if f64::from(arriving.max) * f64::from(leaving.max) < floor {
                omit(arriving.power, leaving.power.into());
                continue;
            }
            for fronts in fronts.blocks(at.corner) {
                let most = f64::from(fronts.strength.max);
                if most * f64::from(leaving.max) < floor {
                    omit(fronts.rest_power, leaving.power.into());
                    break;
                }
                let [max, power] = steps.block(at, fronts.arrival);
                if most * max < floor {
                    omit(fronts.strength.power, power);
                } else if max > 0.0 {
                    selected.push((i, *fronts));
                }
            }
        }
        self.omitted.power += power;
    }

    /// Factor that turns the strengths of a front and a last step into an upper bound: no path is shorter than the line.
    fn of_strengths(&self) -> f64 {
        let distance_m = self.tx.place.distance(self.rx.place);
        self.map.friis.amplitude(1.0) / (distance_m.sqrt() * SLACK)
    }

    /// Computes one promising path, where nothing is known of the link.
    fn look_for_a_floor(&mut self, search: &mut Search) {
        let (fronts, steps) = (&self.tx.fronts, &self.rx.steps);
        let all = (0..).zip(steps.corners()).flat_map(|(i, at)| {
            let blocks = fronts.blocks(at.corner).iter();
            blocks.map(move |f| {
                let [max, _] = steps.block(at, f.arrival);
                (f64::from(f.strength.max) * max, i, *f)
            })
        });
        let Some((_, at, best)) = all.max_by(|p, q| p.0.total_cmp(&q.0)) else {
            return;
        };
        search.blocks.clear();
        search.blocks.push((at, best));
        self.over_blocks(search);
        self.raise_floor_by(&mut search.candidates);
    }

    /// Candidates along the legs of the selected blocks: those fronts that reach the floor with the best of the steps, with those
    /// steps that do with the best of the fronts.
    fn over_blocks(&mut self, search: &mut Search) {
        self.select_crossings(&search.blocks, &mut search.crossings);
        let limits = self.map.config.limits();
        let spread = self.map.friis.amplitude(1.0);
        let at_most = self.of_strengths();
        let fronts = &self.tx.fronts;
        for crossing in &search.crossings {
            self.last_parts(crossing, &mut search.parts);
            let enough = self.floor / (at_most * crossing.after.max());
            let group = fronts.group(crossing.group);
            let strengths = fronts.along_leg(group, crossing.leg);
            for ((id, wave), strength) in fronts.waves_of(group).zip(strengths) {
                let strength = strength.get();
                if strength < enough {
                    self.omit(at_most * strength, crossing.after.power());
                    continue;
                }
                for part in &search.parts {
                    let reflections = wave.reflections + part.reflections;
                    if !limits.allow(reflections, wave.diffractions + 2) {
                        continue;
                    }
                    let length_m = wave.length_m + part.length_m;
                    let candidate = Candidate {
                        bound: spread * strength * part.strength / length_m.sqrt(),
                        front: FrontId::after(id, crossing.leg),
                        leg: part.leg,
                    };
                    self.consider(candidate, &mut search.candidates);
                }
            }
        }
    }

    /// Picks the legs of blocks along which some path may reach the floor. No read depends on an earlier one, so that a processor loads
    /// several blocks at once.
    fn select_crossings(&mut self, blocks: &[(u32, BlockFronts)], selected: &mut Vec<Crossing>) {
        selected.clear();
        let of_square = self.of_strengths().powi(2);
        let floor = self.floor / self.of_strengths();
        let mut power = 0.0;
        let (fronts, steps) = (&self.tx.fronts, &self.rx.steps);
        for &(at, block) in blocks {
            let slots = block.first_slot..block.first_slot + block.legs;
            let after = steps.sums(&steps.corners()[at as usize], slots);
            let rows = fronts.sums(&block).iter().zip(after);
            for (i, (&before, &after)) in (0..).zip(rows) {
                let strength = before.max() * after.max();
                if strength == 0.0 {
                    continue;
                }
                if strength < floor {
                    power += before.power() * after.power() * of_square;
                } else {
                    selected.push(Crossing {
                        at,
                        group: block.group,
                        leg: block.first_leg + i,
                        slot: block.first_slot + i,
                        before,
                        after,
                    });
                }
            }
        }
        self.omitted.power += power;
    }

    /// The last steps along a leg that reach the floor with the best of fronts.
    fn last_parts(&mut self, crossing: &Crossing, parts: &mut Vec<Part>) {
        parts.clear();
        let at_most = self.of_strengths();
        let enough = self.floor / (at_most * crossing.before.max());
        let at = &self.rx.steps.corners()[crossing.at as usize];
        let group = self.tx.fronts.group(crossing.group);
        let leg = self.sources.leg_after(group, crossing.leg);
        let own = self.rx.legs.short(at.legs.clone());
        let strengths = self.rx.steps.of_leg(at, crossing.slot);
        for ((i, last), strength) in at.legs.clone().zip(own).zip(strengths) {
            let strength = strength.get();
            if strength < enough {
                self.omit(at_most * strength, crossing.before.power());
                continue;
            }
            parts.push(Part {
                strength,
                length_m: leg.length_m + last.length_m,
                reflections: leg.reflections + last.reflections,
                leg: i,
            });
        }
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
            let turn = wedge.turn(before, &leg.ray);
            start * (amplitude.value * turn.value + amplitude.slope * turn.by_first)
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
