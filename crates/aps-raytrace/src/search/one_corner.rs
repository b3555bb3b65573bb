//! Candidates over one corner.

use super::buffers::{Buffers, Candidate};
use super::state::Search;
use crate::fronts::FrontId;
use crate::legs::{AtCorner, Legs};

impl Search<'_> {
    /// Finds the candidates over one corner.
    pub fn over_one_corner(&mut self, buffers: &mut Buffers) {
        buffers.candidates.clear();
        buffers.common.clear();
        let [mut tx, mut rx] = [&self.tx.legs, &self.rx.legs].map(Legs::at_corners);
        while let ([p, tx_rest @ ..], [q, rx_rest @ ..]) = (tx, rx) {
            if p.corner == q.corner {
                buffers.common.push((p.clone(), q.clone()));
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
            let common = buffers.common.iter();
            let best = common.max_by(|p, q| product(p).total_cmp(&product(q)));
            if let Some((p, q)) = best {
                self.over_corner(p, q, &mut buffers.candidates);
                self.raise_floor_by(&mut buffers.candidates);
            }
        }
        for (p, q) in &buffers.common {
            self.over_corner(p, q, &mut buffers.candidates);
        }
    }

    /// Finds the candidates over one corner from those legs of the transmitter to those of the receiver.
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
}
