//! As many interactions as a link needs for a given accuracy, and no more.
//!
//! All candidates of a link are listed with an upper bound of their power, which costs little, and
//! computed in the order of their number of interactions. Before each order the bounds of all that
//! is left tell how much it could still change: when that is less than asked for, the link is done.

use crate::link::{Link, Omitted, Pair};
use crate::tracer::{Receiver, Tracer, Transmitter};

/// Spectra count down to this part of the strongest path: -40 dB.
const EFFECT_FLOOR: f64 = 1e-4;

/// A path that may exist.
enum Candidate<'t> {
    Reflection(u32),
    Diffraction(Pair<'t>),
}

impl Tracer<'_> {
    /// Finds the paths of a link order by order.
    pub(crate) fn adapt(&self, tx: &Transmitter, rx: &Receiver, accuracy_db: f64, link: &mut Link) {
        let mut candidates = self.candidates(tx, rx);
        candidates.sort_by_key(|c| c.0);
        link.paths.extend(self.direct(tx, rx));
        let mut floor = self.floor(link);
        let mut done = 0;
        for order in candidates.chunk_by(|p, q| p.0 == q.0) {
            let left_out = Omitted {
                by_bound: candidates.len() - done,
                by_gain: 0,
                power: candidates[done..].iter().map(|c| c.1).sum(),
            };
            let strongest = Self::strongest_power(link);
            if strongest > 0.0 && left_out.effect_db(strongest * EFFECT_FLOOR) < accuracy_db {
                link.stopped_at = Some(order[0].0 - 1);
                link.omitted.by_bound += left_out.by_bound;
                link.omitted.power += left_out.power;
                return;
            }
            for (_, _, candidate) in order {
                match candidate {
                    Candidate::Reflection(image) => {
                        link.paths.extend(self.reflection(tx, rx, *image));
                    }
                    Candidate::Diffraction(pair) => self.consider(pair, &mut floor, link),
                }
            }
            floor = floor.max(self.floor(link));
            done += order.len();
        }
    }

    /// Everything inside the limits: number of interactions, bound of the power, what it is.
    fn candidates<'t>(
        &self,
        tx: &'t Transmitter,
        rx: &'t Receiver,
    ) -> Vec<(usize, f64, Candidate<'t>)> {
        let mut found = Vec::new();
        let max_order = self.config().reflection_limit();
        tx.images
            .for_each_candidate(&rx.sights, max_order, |image| {
                let length_m = tx.images.images[image as usize].point.distance(rx.place);
                let bound = self.friis_amplitude(length_m).powi(2);
                let order = tx.images.order_of(image);
                found.push((order, bound, Candidate::Reflection(image)));
            });
        self.for_each_pair(tx, rx, |pair| {
            let reflections = pair.front.reflections + pair.leg.reflections;
            let order = (reflections + pair.front.diffractions + 1) as usize;
            let bound = self.bound_by_angle(&pair).powi(2);
            found.push((order, bound, Candidate::Diffraction(pair)));
        });
        found
    }
}
