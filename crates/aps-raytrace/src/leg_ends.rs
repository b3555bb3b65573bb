//! Ends of legs at one corner, in columns.

use crate::bound::{Direction, Directions};

/// The ends of legs at one corner, the fewest reflections first, so that the legs a limit allows come first.
#[derive(Debug, Clone, Default)]
pub(crate) struct LegEnds {
    /// Directions of the legs at this corner.
    pub directions: Directions,
    /// Magnitude of each leg's reflection coefficients over the square root of its length.
    pub strengths: Vec<f64>,
    /// Block of each leg, by its place among those that begin or end at this corner.
    pub blocks: Vec<u32>,
    /// Number of these blocks.
    pub block_count: usize,
    /// Slot of each leg, those of a block side by side.
    pub slots: Vec<u32>,
    /// Number of ends with at most this many reflections.
    up_to: Vec<u32>,
}

impl LegEnds {
    /// Adds the end of a leg with as many reflections as the one before, or more.
    pub fn push(
        &mut self,
        direction: &Direction,
        strength: f64,
        reflections: u32,
        block: u32,
        slot: u32,
    ) {
        self.directions.push(direction);
        self.strengths.push(strength);
        self.blocks.push(block);
        self.block_count = self.block_count.max(block as usize + 1);
        self.slots.push(slot);
        let before = self.up_to.last().copied().unwrap_or(0);
        self.up_to.resize(reflections as usize + 1, before);
        self.up_to[reflections as usize] += 1;
    }

    /// Number of ends with at most this many reflections.
    pub fn with_at_most(&self, reflections: u32) -> usize {
        let places = self.up_to.get(reflections as usize).or(self.up_to.last());
        places.map_or(0, |&n| n as usize)
    }
}
