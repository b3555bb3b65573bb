//! The records of the paths that a search found.

use super::buffers::{Buffers, Found};
use super::state::Search;
use crate::link::Link;
use crate::path::{Interactions, PathRecord};

impl Search<'_> {
    /// Applies the dynamic range to all paths and assembles the diffracted ones that remain, the shortest first.
    pub(super) fn cut(&self, buffers: &mut Buffers, link: &mut Link) {
        let reflected = link.paths.iter().map(PathRecord::power);
        let diffracted = buffers.found.iter().map(|f| f.gain.norm_sqr());
        let strongest = reflected.chain(diffracted).fold(0.0, f64::max);
        let floor = strongest * self.map.range * self.map.range;
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
        buffers.found.retain(|f| keep(f.gain.norm_sqr()));
        if buffers.found.is_empty() {
            return;
        }
        // Records are large: sort the small parts that they are made from.
        buffers
            .found
            .sort_unstable_by(|p, q| p.length_m.total_cmp(&q.length_m));
        link.paths
            .sort_unstable_by(|p, q| p.length_m.total_cmp(&q.length_m));
        std::mem::swap(&mut buffers.reflected, &mut link.paths);
        let mut reflected = buffers.reflected.drain(..).peekable();
        for (i, found) in buffers.found.iter().enumerate() {
            while let Some(shorter) = reflected.next_if(|p| p.length_m <= found.length_m) {
                link.paths.push(shorter);
            }
            // The interactions of paths of one length decide their order.
            let before = link.paths.last().map(|path| path.length_m);
            let after = buffers.found.get(i + 1).map(|found| found.length_m);
            let is_tied = [before, after].contains(&Some(found.length_m));
            buffers.path.clear();
            if is_tied || !link.leaves_out_interactions {
                self.interactions(found, &mut buffers.path);
            }
            link.paths
                .push(self.record(found, &buffers.path, &mut buffers.spare));
        }
        link.paths.extend(reflected);
    }

    /// Appends the interactions of a path.
    fn interactions(&self, found: &Found, path: &mut Interactions) {
        let fronts = &self.tx.fronts;
        fronts.interactions(&self.sources, found.front, path);
        let legs = &self.rx.legs;
        let reflections = legs.reflections_of(&legs.all()[found.leg as usize]);
        path.extend(reflections.iter().rev().copied());
    }

    fn record(
        &self,
        found: &Found,
        path: &Interactions,
        spare: &mut Vec<Interactions>,
    ) -> PathRecord {
        let is_long = path.len() > path.inline_size();
        let spare = if is_long { spare.pop() } else { None };
        let mut interactions = spare.unwrap_or_default();
        interactions.extend_from_slice(path);
        let azimuths_rad = [
            self.tx.azimuths_rad[self.tx.fronts.own_leg(found.front)],
            self.rx.azimuths_rad[found.leg as usize],
        ];
        PathRecord::with_azimuths(azimuths_rad, interactions, found.length_m, found.gain)
    }
}
