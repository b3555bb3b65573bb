//! The join of a transmitter and a receiver.

use glam::DVec2;
use num_complex::Complex64;

use crate::chain::{self, Chain};
use crate::error::TraceError;
use crate::fronts::Front;
use crate::legs::{Leg, NEAREST_M};
use crate::path::PathRecord;
use crate::tracer::{Receiver, Tracer, Transmitter};

/// What a trace of one link yields. Reuse it from link to link to save allocations.
#[derive(Debug, Clone, Default)]
pub struct Link {
    /// The paths, by length, then by interactions. Empty when there is none.
    pub paths: Vec<PathRecord>,
    /// Paths inside the limits that were left out for their weakness.
    pub omitted: Omitted,
    /// How many diffractions the paths have when there was none inside the limits.
    pub fallback_diffractions: Option<usize>,
    /// With an accuracy set: the number of interactions beyond which no path was computed.
    pub stopped_at: Option<usize>,
    /// Whether a building closed on all sides lies between the ends: the reason for no path.
    pub is_enclosed: bool,
    /// Diffracted paths not yet assembled.
    pending: Vec<Pending>,
}

/// Paths left out because they lie more than `dynamic_range_db` below the strongest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Omitted {
    /// Paths whose upper bound was too low: their gain was never computed.
    pub by_bound: usize,
    /// Paths whose computed gain was too low.
    pub by_gain: usize,
    /// Upper bound of the sum of their power gains, linear.
    pub power: f64,
}

impl Omitted {
    /// The most that the omitted paths could add to a spectrum where it is at least
    /// `spectrum_power` (linear, same scale as the path powers) \[dB\].
    #[must_use]
    pub fn effect_db(&self, spectrum_power: f64) -> f64 {
        if self.power == 0.0 {
            0.0
        } else {
            10.0 * (self.power / spectrum_power).ln_1p() * std::f64::consts::LOG10_E
        }
    }
}

/// A front and a leg that meet at a corner.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair<'t> {
    front_id: u32,
    pub front: &'t Front,
    leg_id: u32,
    pub leg: &'t Leg,
    /// Of the whole path \[m\].
    pub length_m: f64,
}

#[derive(Debug, Clone, Copy)]
struct Pending {
    front: u32,
    leg: u32,
    length_m: f64,
    gain: Complex64,
}

impl Tracer<'_> {
    /// Finds all paths of a link within the limits.
    ///
    /// No path is an empty list, not an error. Costs some microseconds in a city district at the
    /// default limits.
    ///
    /// # Errors
    /// [`TraceError::Coincident`] when both terminals are at one point,
    /// [`TraceError::TooManyChains`] when what a link without a path needs exceeds `max_wave_bytes`.
    pub fn link(&self, tx: &Transmitter, rx: &Receiver, link: &mut Link) -> Result<(), TraceError> {
        link.paths.clear();
        link.pending.clear();
        link.omitted = Omitted::default();
        link.fallback_diffractions = None;
        link.is_enclosed = false;
        let (from, to) = (tx.place, rx.place);
        if from.distance(to) < NEAREST_M {
            return Err(TraceError::Coincident {
                position: tx.position,
            });
        }
        link.stopped_at = None;
        link.is_enclosed = tx.courtyard != rx.courtyard;
        if link.is_enclosed {
            return Ok(());
        }
        if let Some(accuracy_db) = self.config().accuracy_db {
            self.adapt(tx, rx, accuracy_db, link);
        } else {
            self.reflect(tx, rx, &mut link.paths);
            self.diffract(tx, rx, link);
        }
        self.cut(tx, rx, link);
        if link.paths.is_empty() && self.config().has_fallback() {
            self.fall_back(tx, rx, link)?;
        }
        link.paths.sort_unstable_by(PathRecord::canonical_order);
        if self.origin() != DVec2::ZERO {
            let interactions = link.paths.iter_mut().flat_map(|p| &mut p.interactions);
            interactions.for_each(|i| i.point += self.origin());
        }
        Ok(())
    }

    /// Line of sight and reflections.
    fn reflect(&self, tx: &Transmitter, rx: &Receiver, paths: &mut Vec<PathRecord>) {
        paths.extend(self.direct(tx, rx));
        let max_order = self.config().reflection_limit();
        tx.images
            .for_each_candidate(&rx.sights, max_order, |image| {
                paths.extend(self.reflection(tx, rx, image));
            });
    }

    /// The line of sight, if it is free.
    pub(crate) fn direct(&self, tx: &Transmitter, rx: &Receiver) -> Option<PathRecord> {
        let (from, to) = (tx.place, rx.place);
        let is_free = !self.local().is_blocked(from, to, [None; 2]);
        is_free.then(|| self.record(from, to, Chain::direct(from, to)))
    }

    /// The path over an image of the transmitter, if it is one.
    pub(crate) fn reflection(
        &self,
        tx: &Transmitter,
        rx: &Receiver,
        image: u32,
    ) -> Option<PathRecord> {
        let (from, to) = (tx.place, rx.place);
        chain::resolve(self.local(), self.reflectors(), &tx.images, image, from, to)
            .map(|chain| self.record(from, to, chain))
    }

    fn record(&self, tx: DVec2, rx: DVec2, chain: Chain) -> PathRecord {
        let gain = chain.coefficient * self.friis(chain.length_m);
        PathRecord::new(tx, rx, chain.reflections, chain.length_m, gain)
    }

    /// Every pair of a front and a leg at the same corner is a path.
    fn diffract(&self, tx: &Transmitter, rx: &Receiver, link: &mut Link) {
        if rx.legs.all().is_empty() {
            return;
        }
        let mut floor = self.floor(link);
        self.for_each_pair(tx, rx, |pair| self.consider(&pair, &mut floor, link));
    }

    /// Amplitude below which a path is out of the dynamic range, as far as known.
    pub(crate) fn floor(&self, link: &Link) -> f64 {
        let strongest = link.paths.iter().map(PathRecord::power).fold(0.0, f64::max);
        strongest.sqrt() * self.range()
    }

    /// All pairs of a front of the transmitter and a leg of the receiver at one corner that are
    /// within the limits.
    #[inline]
    pub(crate) fn for_each_pair<'t>(
        &self,
        tx: &'t Transmitter,
        rx: &'t Receiver,
        mut visit: impl FnMut(Pair<'t>),
    ) {
        let limits = self.config().limits();
        for (leg, leg_id) in rx.legs.all().iter().zip(0..) {
            for (front_id, front) in tx.fronts.at(leg.corner as usize) {
                let reflections = front.reflections + leg.reflections;
                if limits.allow(reflections, front.diffractions + 1) {
                    visit(Pair {
                        front_id,
                        front,
                        leg_id,
                        leg,
                        length_m: front.length_m + leg.ray.length_m,
                    });
                }
            }
        }
    }

    /// Upper bound of the amplitude of a pair, at the price of a few multiplications.
    fn bound(&self, pair: &Pair<'_>) -> f64 {
        let wedge = &self.corners().wedges[pair.leg.corner as usize];
        self.scale(pair) * wedge.coefficient_bound(&pair.front.ray, &pair.leg.ray)
    }

    /// A closer upper bound of the amplitude of a pair.
    pub(crate) fn bound_by_angle(&self, pair: &Pair<'_>) -> f64 {
        let wedge = &self.corners().wedges[pair.leg.corner as usize];
        self.scale(pair) * wedge.coefficient_bound_by_angle(&pair.front.ray, &pair.leg.ray)
    }

    /// Amplitude of a pair over |D| at its corner.
    fn scale(&self, pair: &Pair<'_>) -> f64 {
        let strength = pair.front.strength * pair.leg.strength;
        self.friis_amplitude(1.0) * strength / pair.length_m.sqrt()
    }

    /// Computes a pair unless it is too weak to matter; `floor` rises with what is found.
    pub(crate) fn consider(&self, pair: &Pair<'_>, floor: &mut f64, link: &mut Link) {
        let bound = self.bound(pair);
        if bound < *floor {
            link.omitted.by_bound += 1;
            link.omitted.power += bound * bound;
            return;
        }
        let gain = self.diffracted_gain(pair.front, pair.leg, pair.length_m);
        // Not norm(): gains are far from the ends of the range that hypot guards.
        let magnitude = gain.norm_sqr().sqrt();
        if magnitude < *floor {
            link.omitted.by_gain += 1;
            link.omitted.power += magnitude * magnitude;
            return;
        }
        *floor = floor.max(magnitude * self.range());
        link.pending.push(Pending {
            front: pair.front_id,
            leg: pair.leg_id,
            length_m: pair.length_m,
            gain,
        });
    }

    /// Power of the strongest path found so far, assembled or not.
    pub(crate) fn strongest_power(link: &Link) -> f64 {
        let reflected = link.paths.iter().map(PathRecord::power);
        let diffracted = link.pending.iter().map(|p| p.gain.norm_sqr());
        reflected.chain(diffracted).fold(0.0, f64::max)
    }

    fn diffracted_gain(&self, front: &Front, leg: &Leg, length_m: f64) -> Complex64 {
        let wedge = &self.corners().wedges[leg.corner as usize];
        let coefficient = wedge.coefficient(&front.ray, &leg.ray);
        let spread = (leg.ray.length_m * length_m).sqrt();
        // friis() divides by the length itself: multiply it back.
        self.friis(length_m) * length_m * front.amplitude * coefficient * leg.coefficient / spread
    }

    /// Applies the dynamic range to all paths and assembles the diffracted ones that remain.
    fn cut(&self, tx: &Transmitter, rx: &Receiver, link: &mut Link) {
        let floor = Self::strongest_power(link) * self.range() * self.range();
        let omitted = &mut link.omitted;
        let mut keep = |power: f64| {
            // A gain of exactly zero is no path at all.
            let keep = power >= floor && power > 0.0;
            if !keep {
                omitted.by_gain += 1;
                omitted.power += power;
            }
            keep
        };
        link.paths.retain(|p| keep(p.power()));
        for p in &link.pending {
            if keep(p.gain.norm_sqr()) {
                let leg = &rx.legs.all()[p.leg as usize];
                let interactions = tx.fronts.interactions(
                    self.corners(),
                    &tx.legs,
                    self.between(),
                    p.front,
                    (&rx.legs, leg),
                );
                let path = PathRecord::new(tx.place, rx.place, interactions, p.length_m, p.gain);
                link.paths.push(path);
            }
        }
    }
}
