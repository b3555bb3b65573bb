//! Fronts by block, in the order in which a search goes over them.

use std::ops::Range;

use crate::strength::Strength;

/// The fronts that continue the waves of one group along the legs of one block.
///
/// A search reads thousands of these one after the other: all that it needs of the block is here.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockFronts {
    /// The block's place among those that arrive at the corner.
    pub arrival: u32,
    pub group: u32,
    pub strength: Strength,
    /// Upper bound of the sum of squares of these and all weaker ones at the corner.
    pub rest_power: f32,
    pub first_leg: u32,
    /// Slot of the first leg at the corner where it arrives.
    pub first_slot: u32,
    /// Number of legs.
    pub legs: u32,
}

/// The fronts at one corner but for the transmitter's own legs.
#[derive(Debug, Clone, Default)]
struct Arriving {
    strength: Strength,
    blocks: Range<u32>,
}

/// The fronts of one transmitter by the corner where they end, the strongest blocks first.
#[derive(Debug, Clone, Default)]
pub(crate) struct Blocks {
    fronts: Vec<BlockFronts>,
    corners: Vec<Arriving>,
}

impl Blocks {
    /// Sorts blocks of fronts, each with the corner where it ends.
    pub fn new(mut blocks: Vec<(u32, BlockFronts)>, corners: usize) -> Self {
        blocks.sort_unstable_by(|(p_to, p), (q_to, q)| {
            let by_max = q.strength.max.total_cmp(&p.strength.max);
            let by_id = (p.arrival, p.group).cmp(&(q.arrival, q.group));
            p_to.cmp(q_to).then(by_max).then(by_id)
        });
        let mut corners = vec![Arriving::default(); corners];
        let mut first = 0;
        for at_corner in blocks.chunk_by_mut(|p, q| p.0 == q.0) {
            let arriving = &mut corners[at_corner[0].0 as usize];
            for (_, fronts) in at_corner.iter_mut().rev() {
                arriving.strength.add(&fronts.strength);
                fronts.rest_power = arriving.strength.power;
            }
            arriving.blocks = first..first + at_corner.len() as u32;
            first = arriving.blocks.end;
        }
        Self {
            fronts: blocks.iter().map(|&(_, fronts)| fronts).collect(),
            corners,
        }
    }

    /// Strength of all blocks at a corner together.
    pub fn strength(&self, corner: u32) -> &Strength {
        &self.corners[corner as usize].strength
    }

    /// The blocks at a corner, the strongest first.
    pub fn at(&self, corner: u32) -> &[BlockFronts] {
        let Range { start, end } = self.corners[corner as usize].blocks;
        &self.fronts[start as usize..end as usize]
    }
}
