//! State of a search: both ends, the floor, and what is left out below it.

use super::buffers::{Buffers, Candidate, Found};
use crate::fronts::Sources;
use crate::link::Omitted;
use crate::map::Map;
use crate::terminal::{Receiver, Transmitter};

/// Factor that lowers the floor with which bounds are compared: far more than the rounding of bounds and amplitudes.
pub(super) const SLACK: f64 = 1.0 - 1e-9;

/// State of one search.
pub(super) struct Search<'t> {
    pub map: &'t Map<'t>,
    pub tx: &'t Transmitter,
    pub rx: &'t Receiver,
    pub sources: Sources<'t>,
    /// Factor that turns the strengths of a front and a last step into an upper bound: no path is shorter than the line.
    pub of_strengths: f64,
    /// Amplitude below which a path is out of the dynamic range, as far as known.
    pub floor: f64,
    /// Pairs computed.
    pub computed: usize,
    pub omitted: Omitted,
}

impl Search<'_> {
    /// Raises the floor to what an amplitude leaves within the dynamic range.
    #[inline]
    pub fn raise_floor(&mut self, amplitude: f64) {
        self.floor = self.floor.max(amplitude * self.map.range * SLACK);
    }

    /// Counts the pairs of a front and a leg of the receiver that make a path within the limits.
    pub fn paths_within_limits(&self) -> usize {
        let limits = self.map.config.limits();
        let fronts = &self.tx.fronts;
        let counts = self.rx.legs.counts().iter();
        let paths = counts.map(|of| of.legs * fronts.paths(of.corner, of.reflections, &limits));
        paths.sum()
    }

    /// Computes the most promising of candidates to learn a floor from it, and drops them all.
    pub fn raise_floor_by(&mut self, candidates: &mut Vec<Candidate>) {
        let by_bound = |p: &&Candidate, q: &&Candidate| p.bound.total_cmp(&q.bound);
        if let Some(best) = candidates.iter().max_by(by_bound) {
            let gain = self.found(best).gain;
            self.raise_floor(gain.norm_sqr().sqrt());
        }
        candidates.clear();
    }

    /// Adds an omitted path's power, given over the square of an amplitude.
    #[inline]
    pub fn omit(&mut self, amplitude: f64, power: f64) {
        self.omitted.power += amplitude * amplitude * power;
    }

    /// Keeps a candidate that may reach the floor, and leaves out others.
    #[inline]
    pub fn consider(&mut self, candidate: Candidate, candidates: &mut Vec<Candidate>) {
        if candidate.bound < self.floor {
            self.omitted.power += candidate.bound * candidate.bound;
        } else {
            candidates.push(candidate);
        }
    }

    /// Computes the candidates, the most promising first, until none of the others can reach the floor.
    pub fn compute(&mut self, buffers: &mut Buffers) {
        if self.map.range > 0.0 {
            let descending = |p: &Candidate, q: &Candidate| q.bound.total_cmp(&p.bound);
            buffers.candidates.sort_unstable_by(descending);
        }
        for candidate in &buffers.candidates {
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
                buffers.found.push(found);
            }
        }
    }

    /// Computes the gain of a candidate.
    pub fn found(&self, candidate: &Candidate) -> Found {
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
