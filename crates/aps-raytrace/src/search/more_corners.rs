//! Candidates over more than one corner: blocks, the legs of blocks, then waves and last steps along a leg.

use super::buffers::{Buffers, Candidate, Crossing, Part};
use super::state::Search;
use crate::fronts::{BlockFronts, FrontId};

impl Search<'_> {
    /// Finds the candidates over several corners.
    pub(super) fn over_more_corners(&mut self, buffers: &mut Buffers) {
        buffers.candidates.clear();
        if self.floor == 0.0 && self.map.range > 0.0 {
            self.look_for_a_floor(buffers);
        }
        self.select_blocks(&mut buffers.blocks);
        self.over_blocks(buffers);
    }

    /// Picks the blocks of which some path may reach the floor.
    fn select_blocks(&mut self, selected: &mut Vec<(u32, BlockFronts)>) {
        selected.clear();
        let of_square = self.of_strengths.powi(2);
        let floor = self.floor / self.of_strengths;
        let mut power = 0.0;
        let mut omit = |p: f32, q: f64| power += f64::from(p) * q * of_square;
        let steps = &self.rx.steps;
        let fronts = self.tx.fronts.blocks();
        for (i, at) in (0..).zip(steps.corners()) {
            let (arriving, leaving) = (fronts.strength(at.corner), &at.strength);
            if f64::from(arriving.max) * f64::from(leaving.max) < floor {
                omit(arriving.power, leaving.power.into());
                continue;
            }
            for fronts in fronts.at(at.corner) {
                let most = f64::from(fronts.strength.max);
                if most * f64::from(leaving.max) < floor {
                    omit(fronts.rest_power, leaving.power.into());
                    break;
                }
                let steps = steps.block(at, fronts.arrival);
                if most * steps.max() < floor {
                    omit(fronts.strength.power, steps.power());
                } else if steps.max() > 0.0 {
                    selected.push((i, *fronts));
                }
            }
        }
        self.omitted.power += power;
    }

    /// Computes one promising path, where nothing is known of the link.
    fn look_for_a_floor(&mut self, buffers: &mut Buffers) {
        let (fronts, steps) = (self.tx.fronts.blocks(), &self.rx.steps);
        let all = (0..).zip(steps.corners()).flat_map(|(i, at)| {
            let blocks = fronts.at(at.corner).iter();
            blocks.map(move |f| {
                let steps = steps.block(at, f.arrival);
                (f64::from(f.strength.max) * steps.max(), i, *f)
            })
        });
        let Some((_, at, best)) = all.max_by(|p, q| p.0.total_cmp(&q.0)) else {
            return;
        };
        buffers.blocks.clear();
        buffers.blocks.push((at, best));
        self.over_blocks(buffers);
        self.raise_floor_by(&mut buffers.candidates);
    }

    /// Finds the candidates along the legs of the selected blocks: those fronts that reach the floor with the best of the steps, with those
    /// steps that do with the best of the fronts.
    fn over_blocks(&mut self, buffers: &mut Buffers) {
        self.select_crossings(&buffers.blocks, &mut buffers.crossings);
        let limits = self.map.config.limits();
        let spread = self.map.friis.amplitude(1.0);
        let at_most = self.of_strengths;
        let fronts = &self.tx.fronts;
        for crossing in &buffers.crossings {
            self.last_parts(crossing, &mut buffers.parts);
            let enough = self.floor / (at_most * crossing.after.max());
            let group = fronts.group(crossing.group);
            let strengths = fronts.along_leg(group, crossing.leg);
            for ((id, wave), strength) in fronts.waves_of(group).zip(strengths) {
                let strength = strength.get();
                if strength < enough {
                    self.omit(at_most * strength, crossing.after.power());
                    continue;
                }
                for part in &buffers.parts {
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
                    self.consider(candidate, &mut buffers.candidates);
                }
            }
        }
    }

    /// Picks the legs of blocks along which some path may reach the floor. No read depends on an earlier one, so that a processor loads
    /// several blocks at once.
    fn select_crossings(&mut self, blocks: &[(u32, BlockFronts)], selected: &mut Vec<Crossing>) {
        selected.clear();
        let at_most = self.of_strengths;
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
                if at_most * strength < self.floor {
                    self.omit(at_most, before.power() * after.power());
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
    }

    /// Picks the last steps along a leg that reach the floor with the best of fronts.
    fn last_parts(&mut self, crossing: &Crossing, parts: &mut Vec<Part>) {
        parts.clear();
        let at_most = self.of_strengths;
        let enough = self.floor / (at_most * crossing.before.max());
        let at = &self.rx.steps.corners()[crossing.at as usize];
        let group = self.tx.fronts.group(crossing.group);
        let leg = self.sources.leg_after(group, crossing.leg);
        let own = self.rx.legs.summaries(at.legs.clone());
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
}
