//! Last steps: the continuation of waves from the corners that a receiver sees to the receiver.
//!
//! A last step begins with a leg between corners, turns at the corner that the receiver sees, and ends with one of the receiver's
//! legs. As with fronts, an upper bound of the strength of each is kept, and the largest of each block.

use std::ops::Range;

use crate::between::Between;
use crate::bound::Direction;
use crate::legs::{Corners, Leg, Legs};
use crate::limits::Limits;
use crate::strength::{Bound, CornerStrengths, RowSum, Rows, Strength, Table};

/// The steps at one corner.
#[derive(Debug, Clone)]
pub(crate) struct CornerSteps {
    pub corner: u32,
    pub strength: Strength,
    /// Index in `blocks` of the first one that arrives.
    first_block: u32,
    /// The receiver's own legs to it.
    pub legs: Range<u32>,
    /// Bounds of last steps, one row a slot: |D| times the strength of the own leg, or more, one column an own leg; 0 beyond the limits.
    rows: Rows,
}

/// Last steps of one receiver, over all corners it sees.
#[derive(Debug, Clone, Default)]
pub(crate) struct LastSteps {
    /// Directions of the receiver's own legs at their corners.
    own: Vec<Direction>,
    table: Table,
    corners: Vec<CornerSteps>,
    /// Maximum and sum of squares of each arriving block, corner by corner.
    blocks: Vec<RowSum>,
}

impl LastSteps {
    /// Finds the last steps over the receiver's legs. `None` if they take more than the limit.
    pub fn find(
        corners: &Corners,
        legs: &Legs,
        between: Option<&Between>,
        limits: &Limits,
    ) -> Option<Self> {
        let direction = |leg: &Leg| {
            let wedge = &corners.wedges[leg.corner as usize];
            wedge.direction(&leg.ray)
        };
        let mut steps = Self {
            own: legs.all().iter().map(direction).collect(),
            ..Self::default()
        };
        let Some(between) = between else {
            return Some(steps);
        };
        let count = |leg: &Leg| {
            let left = limits.left(leg.reflections, 2);
            left.map_or(0, |left| between.arriving(leg.corner).with_at_most(left))
        };
        // The steps of receivers fill most of the memory: reserve no byte more than they take.
        let (mut rows, mut bounds) = (0, 0);
        let mut bytes = 0;
        for at in legs.at_corners() {
            let (ends, kinds) = (between.arriving(at.corner).slots.len(), at.legs.len());
            rows += ends;
            bounds += ends * kinds;
            bytes += ends * Table::row_bytes(kinds);
        }
        if bytes > limits.bytes {
            return None;
        }
        steps.table.reserve_exact(rows, bounds);
        let mut corner_strengths = CornerStrengths::default();
        let mut blocks = Vec::new();
        for at in legs.at_corners() {
            let wedge = &corners.wedges[at.corner as usize].bound;
            let ends = between.arriving(at.corner);
            let rows = steps.table.add(ends.slots.len(), at.legs.len());
            corner_strengths.clear(ends.slots.len());
            for (kind, i) in at.legs.clone().map(|i| i as usize).enumerate() {
                let leg = &legs.all()[i];
                let ray = (wedge, &steps.own[i]);
                let table = (&mut steps.table, rows, kind);
                corner_strengths.add(ray, (ends, count(leg)), |_| leg.strength, table);
            }
            blocks.clear();
            blocks.resize(ends.block_count, Strength::default());
            corner_strengths.finish(ends, (&mut steps.table, rows), |place, strength| {
                blocks[ends.blocks[place] as usize].add(&strength);
            });
            let mut strength = Strength::default();
            blocks.iter().for_each(|block| strength.add(block));
            steps.corners.push(CornerSteps {
                corner: at.corner,
                strength,
                first_block: steps.blocks.len() as u32,
                legs: at.legs.clone(),
                rows,
            });
            let rounded = blocks.iter().map(Strength::rounded);
            steps.blocks.extend(rounded);
        }
        steps.blocks.shrink_to_fit();
        Some(steps)
    }

    /// The receiver's own leg as seen at its corner.
    pub fn own(&self, leg: usize) -> &Direction {
        &self.own[leg]
    }

    /// The corners that the receiver sees.
    pub fn corners(&self) -> &[CornerSteps] {
        &self.corners
    }

    /// Largest and sum of squares of the steps at a corner along the legs of a block that arrives there.
    #[inline]
    pub fn block(&self, at: &CornerSteps, arrival: u32) -> RowSum {
        self.blocks[(at.first_block + arrival) as usize]
    }

    /// Largest and sum of squares of the steps that begin with each of the legs in some slots of a corner; all 0 beyond the limits.
    #[inline]
    pub fn sums(&self, at: &CornerSteps, slots: Range<u32>) -> &[RowSum] {
        self.table.sums(at.rows, slots)
    }

    /// Strengths of the steps that begin with the leg in a slot, by own leg at the corner.
    #[inline]
    pub fn of_leg(&self, at: &CornerSteps, slot: u32) -> &[Bound] {
        self.table.row(at.rows, slot)
    }
}
