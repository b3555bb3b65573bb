//! The join of a transmitter and a receiver: line of sight, reflections, the search, the fallback.

use glam::DVec2;

use crate::chain::{self, Chain};
use crate::error::TraceError;
use crate::fallback;
use crate::legs::NEAREST_M;
use crate::link::{Link, Omitted};
use crate::map::Map;
use crate::path::PathRecord;
use crate::search;
use crate::terminal::{Receiver, Transmitter};

/// Finds all paths of a link within the limits.
pub(crate) fn trace(
    map: &Map<'_>,
    tx: &Transmitter,
    rx: &Receiver,
    link: &mut Link,
) -> Result<(), TraceError> {
    link.buffers.take_back(&mut link.paths);
    link.omitted = Omitted::default();
    link.fallback_diffractions = None;
    link.is_enclosed = false;
    for (terminal, own) in [("transmitter", tx.map), ("receiver", rx.map)] {
        if own != map.scene.id {
            return Err(TraceError::Foreign { terminal });
        }
    }
    if tx.place.distance(rx.place) < NEAREST_M {
        return Err(TraceError::Coincident {
            position: tx.position,
        });
    }
    link.is_enclosed = tx.courtyard != rx.courtyard;
    if link.is_enclosed {
        return Ok(());
    }
    reflect(map, tx, rx, &mut link.paths);
    search::diffract(map, tx, rx, link);
    if link.paths.is_empty() && map.config.has_fallback() {
        fallback::fall_back(map, tx, rx, link)?;
    }
    link.paths.sort_unstable_by(PathRecord::canonical_order);
    if link.leaves_out_interactions {
        let paths = link.paths.iter_mut();
        paths.for_each(|path| path.interactions.clear());
    }
    if map.scene.origin != DVec2::ZERO {
        let interactions = link.paths.iter_mut().flat_map(|p| &mut p.interactions);
        interactions.for_each(|i| i.point += map.scene.origin);
    }
    Ok(())
}

/// Finds the line of sight and the reflections.
fn reflect(map: &Map<'_>, tx: &Transmitter, rx: &Receiver, paths: &mut Vec<PathRecord>) {
    let (from, to) = (tx.place, rx.place);
    let record = |chain: Chain| {
        let gain = chain.coefficient * map.friis.gain(chain.length_m);
        PathRecord::new(from, to, chain.reflections, chain.length_m, gain)
    };
    if tx.visibility.sees(map.scene.local(), to) {
        paths.push(record(Chain::direct(from, to)));
    }
    tx.images.for_each_candidate(&rx.visible_walls, |image| {
        let chain = chain::resolve(
            map.scene.local(),
            &map.reflectors,
            &tx.images,
            image,
            from,
            to,
        );
        paths.extend(chain.map(record));
    });
}
