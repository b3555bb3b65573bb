//! Last steps: the continuation of waves from the corners that a receiver sees to the receiver.
//!
//! A last step begins with a leg between corners, turns at the corner that the receiver sees, and ends with one of the receiver's
//! legs. As with fronts, an upper bound of the strength of each is kept, and the largest of each block.

use std::ops::Range;

use crate::between::{Between, Block};
use crate::bound::Direction;
use crate::fronts::Limits;
use crate::legs::{Corners, Leg, Legs};
use crate::strength::{Bound, Places, Row, Rows, Strength, Table};

/// The steps along the legs of a block.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockSteps {
    pub block: u32,
    pub strength: Strength,
    /// Upper bound of the sum of squares of these and all weaker ones at the corner.
    pub rest_power: f32,
}

/// The steps at one corner.
#[derive(Debug, Clone)]
pub(crate) struct CornerSteps {
    pub corner: u32,
    pub strength: Strength,
    /// The strongest first.
    blocks: Range<u32>,
    /// The receiver's own legs to it.
    pub legs: Range<u32>,
    /// By slot of the legs that arrive there, by own leg: |D| times the strength of the own leg, or more; 0 beyond the limits.
    rows: Rows,
}

/// Last steps of one receiver, over all corners it sees.
#[derive(Debug, Clone, Default)]
pub(crate) struct LastSteps {
    /// The receiver's own legs as seen at their corners.
    own: Vec<Direction>,
    table: Table,
    corners: Vec<CornerSteps>,
    blocks: Vec<BlockSteps>,
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
            wedge.bound.direction(&leg.ray)
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
        let bounds = legs.at_corners().iter().map(|at| {
            let ends = between.arriving(at.corner).slots.len();
            ends * (2 + at.legs.len())
        });
        let bounds = bounds.sum();
        if bounds * size_of::<Bound>() > limits.bytes {
            return None;
        }
        steps.table.reserve_exact(bounds);
        let mut places = Places::default();
        let mut blocks = Vec::new();
        for at in legs.at_corners() {
            let wedge = &corners.wedges[at.corner as usize].bound;
            let ends = between.arriving(at.corner);
            let rows = steps.table.add(ends.slots.len(), at.legs.len());
            places.clear(ends.slots.len());
            for (kind, i) in at.legs.clone().map(|i| i as usize).enumerate() {
                let leg = &legs.all()[i];
                let ray = (wedge, &steps.own[i]);
                let table = (&mut steps.table, rows, kind);
                places.add(ray, (ends, count(leg)), |_| leg.strength, table);
            }
            let ids = between.blocks_to(at.corner);
            blocks.clear();
            blocks.resize(ids.len(), Strength::default());
            places.finish(ends, (&mut steps.table, rows), |place, strength| {
                blocks[(ends.blocks[place] - ids.start) as usize].add(&strength);
            });
            let mut at = CornerSteps {
                corner: at.corner,
                strength: Strength::default(),
                blocks: 0..0,
                legs: at.legs.clone(),
                rows,
            };
            steps.add_blocks(&mut at, ids.zip(&blocks));
            steps.corners.push(at);
        }
        steps.blocks.shrink_to_fit();
        Some(steps)
    }

    /// Adds the steps along blocks to a corner.
    fn add_blocks<'b>(
        &mut self,
        at: &mut CornerSteps,
        strengths: impl Iterator<Item = (u32, &'b Strength)>,
    ) {
        let first = self.blocks.len();
        for (block, &strength) in strengths.filter(|(_, strength)| strength.max > 0.0) {
            self.blocks.push(BlockSteps {
                block,
                strength,
                rest_power: 0.0,
            });
        }
        let blocks = &mut self.blocks[first..];
        blocks.sort_unstable_by(|p, q| {
            let by_max = q.strength.max.total_cmp(&p.strength.max);
            by_max.then(p.block.cmp(&q.block))
        });
        let mut all = Strength::default();
        for steps in blocks.iter_mut().rev() {
            all.add(&steps.strength);
            steps.rest_power = all.power;
        }
        at.strength = all;
        at.blocks = first as u32..self.blocks.len() as u32;
    }

    /// The receiver's own leg as seen at its corner.
    pub fn own(&self, leg: usize) -> &Direction {
        &self.own[leg]
    }

    /// The corners that the receiver sees.
    pub fn corners(&self) -> &[CornerSteps] {
        &self.corners
    }

    /// The steps at one of them, by block, the strongest first.
    pub fn blocks(&self, at: &CornerSteps) -> &[BlockSteps] {
        &self.blocks[at.blocks.start as usize..at.blocks.end as usize]
    }

    /// Strengths of the steps at a corner that begin with each of the legs of a block; all 0 beyond the limits.
    #[inline]
    pub fn rows(&self, at: &CornerSteps, block: &Block) -> impl Iterator<Item = Row<'_>> {
        let slots = block.first_slot..block.first_slot + block.legs.len() as u32;
        self.table.rows(at.rows, slots)
    }
}
