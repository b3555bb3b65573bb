//! The search for the diffracted paths of a link.
//!
//! Every pair of a front of the transmitter and a leg of the receiver at one corner is a path. Most are too weak to count. A bound of
//! each one's amplitude costs a few nanoseconds, and one product bounds all that take the legs of one block; only those whose bound
//! is within the dynamic range of the strongest path known are computed, the most promising first. Nothing is left out but by a bound
//! that is proven, so the paths that remain are the same as if all were computed.

mod assemble;
mod buffers;
mod more_corners;
mod one_corner;
mod state;

use crate::fronts::Sources;
use crate::link::{Link, Omitted};
use crate::map::Map;
use crate::path::PathRecord;
use crate::terminal::{Receiver, Transmitter};
use state::{SLACK, Search};

pub(crate) use buffers::Buffers;

/// Adds the diffracted paths to the others of a link, and applies the dynamic range to all.
pub(crate) fn diffract(map: &Map<'_>, tx: &Transmitter, rx: &Receiver, link: &mut Link) {
    let mut buffers = std::mem::take(&mut link.buffers);
    buffers.found.clear();
    let distance_m = tx.place.distance(rx.place);
    let mut search = Search {
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
    search.raise_floor(strongest.sqrt());
    search.over_one_corner(&mut buffers);
    search.compute(&mut buffers);
    if map.between.is_some() {
        search.over_more_corners(&mut buffers);
        search.compute(&mut buffers);
    }
    link.omitted = search.omitted;
    link.omitted.by_bound = search.paths_within_limits() - search.computed;
    search.cut(&mut buffers, link);
    link.buffers = buffers;
}
