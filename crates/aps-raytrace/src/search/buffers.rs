//! Memory of a search: candidates, found paths, and what leads to them.

use num_complex::Complex64;

use crate::fronts::{BlockFronts, FrontId};
use crate::legs::AtCorner;
use crate::path::{Interactions, PathRecord};
use crate::strength::RowSum;

/// A path that may be strong enough.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// Upper bound of the path's amplitude.
    pub bound: f64,
    pub front: FrontId,
    /// The last leg, one of the receiver's.
    pub leg: u32,
}

/// A path that is strong enough as far as known, not yet assembled.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub front: FrontId,
    pub leg: u32,
    pub length_m: f64,
    pub gain: Complex64,
}

/// A leg between corners along which some path may reach the floor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// Corner where it ends, by its place among those that the receiver sees.
    pub at: u32,
    /// The waves at the corner where it begins.
    pub group: u32,
    /// Number among the legs that leave that corner.
    pub leg: u32,
    /// Slot at the corner where it ends.
    pub slot: u32,
    /// Strengths of the fronts along it.
    pub before: RowSum,
    /// Strengths of the last steps that begin with it.
    pub after: RowSum,
}

/// A leg between corners and a last step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub strength: f64,
    pub length_m: f64,
    pub reflections: u32,
    pub leg: u32,
}

/// Memory of a search, to be used again.
#[derive(Debug, Clone, Default)]
pub(crate) struct Buffers {
    /// Corners that both ends reach.
    pub(super) common: Vec<(AtCorner, AtCorner)>,
    pub(super) candidates: Vec<Candidate>,
    /// Blocks of fronts, with the corner where they end, by its place among those that the receiver sees.
    pub(super) blocks: Vec<(u32, BlockFronts)>,
    pub(super) crossings: Vec<Crossing>,
    pub(super) parts: Vec<Part>,
    pub(super) found: Vec<Found>,
    /// Reflected paths while they are merged with the diffracted ones.
    pub(super) reflected: Vec<PathRecord>,
    /// Interactions of the path in the making.
    pub(super) path: Interactions,
    /// Empty lists with room for many interactions, of former paths.
    pub(super) spare: Vec<Interactions>,
}

impl Buffers {
    /// Recycles the interactions of the previous link's paths, and lets go of what was left of those before.
    pub fn take_back(&mut self, paths: &mut Vec<PathRecord>) {
        self.spare.clear();
        let former = paths.drain(..).map(|path| path.interactions);
        let long = former.filter(|interactions| interactions.spilled());
        self.spare.extend(long.map(|mut interactions| {
            interactions.clear();
            interactions
        }));
    }
}
