//! Last steps: the continuation of waves from the corners that a receiver sees to the receiver.
//!
//! A last step begins with a leg between corners, turns at the corner that the receiver sees, and ends with one of the receiver's
//! legs. As with fronts, an upper bound of the strength of each is kept, and the largest of each block.

use std::ops::Range;

use crate::between::{Between, Block};
use crate::bound::{Direction, rounded_up};
use crate::fronts::Limits;
use crate::legs::{Corners, Leg, Legs};
use crate::strength::{Rows, Strength};

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
    blocks: Range<usize>,
    /// The receiver's own legs to it.
    pub legs: Range<u32>,
    first_strength: usize,
    first_slot: usize,
    /// Places that the limits leave to any of them.
    places: usize,
}

/// Last steps of one receiver, over all corners it sees.
#[derive(Debug, Clone, Default)]
pub(crate) struct LastSteps {
    /// The receiver's own legs as seen at their corners.
    own: Vec<Direction>,
    /// By corner, by place among the ends that arrive there, by own leg: |D| times the strength of the own leg, or more; 0 beyond
    /// the limits.
    strengths: Vec<f32>,
    /// By corner and by slot of the legs that arrive there.
    slots: Vec<Strength>,
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
        let places = |legs: &[Leg]| legs.iter().map(count).max().unwrap_or(0);
        let by_corner = || legs.all().chunk_by(|p, q| p.corner == q.corner);
        // The steps of receivers fill most of the memory: reserve no byte more than they take.
        let strengths = by_corner().map(|legs| places(legs) * legs.len()).sum();
        let ends = |legs: &[Leg]| between.arriving(legs[0].corner).slots.len();
        let slots = by_corner().map(ends).sum();
        let bytes = strengths * size_of::<f32>() + slots * size_of::<Strength>();
        if bytes > limits.bytes {
            return None;
        }
        steps.strengths.reserve_exact(strengths);
        steps.slots.reserve_exact(slots);
        let mut rows = Rows::default();
        let mut blocks = Vec::new();
        let mut first_leg = 0;
        for legs in by_corner() {
            let corner = legs[0].corner;
            let wedge = &corners.wedges[corner as usize].bound;
            let ends = between.arriving(corner);
            let places = places(legs);
            let first = steps.strengths.len();
            steps.strengths.resize(first + places * legs.len(), 0.0);
            rows.clear(ends.blocks.len());
            for (i, leg) in legs.iter().enumerate() {
                let own = &steps.own[first_leg + i];
                let bounds = rows.bounds(wedge, own, &ends.directions, count(leg));
                let strengths = steps.strengths.iter_mut().skip(first + i);
                let strengths = strengths.step_by(legs.len());
                for (bound, rounded) in bounds.iter_mut().zip(strengths) {
                    *bound *= leg.strength;
                    *rounded = rounded_up(*bound);
                }
                rows.add();
            }
            let ids = between.blocks_to(corner);
            blocks.clear();
            blocks.resize(ids.len(), Strength::default());
            let first_slot = steps.slots.len();
            steps
                .slots
                .resize(first_slot + ends.slots.len(), Strength::default());
            let slots = &mut steps.slots[first_slot..];
            for (place, strength) in rows.by_place().enumerate() {
                blocks[(ends.blocks[place] - ids.start) as usize].add(&strength);
                slots[ends.slots[place] as usize] = strength;
            }
            let mut at = CornerSteps {
                corner,
                strength: Strength::default(),
                blocks: 0..0,
                legs: first_leg as u32..(first_leg + legs.len()) as u32,
                first_strength: first,
                first_slot,
                places,
            };
            steps.add_blocks(&mut at, ids.zip(&blocks));
            steps.corners.push(at);
            first_leg += legs.len();
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
        at.blocks = first..self.blocks.len();
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
        &self.blocks[at.blocks.clone()]
    }

    /// Strength of the steps at a corner that begin with each of the legs of a block; all 0 beyond the limits.
    #[inline]
    pub fn slots(&self, at: &CornerSteps, block: &Block) -> &[Strength] {
        &self.slots[at.first_slot + block.first_slot as usize..][..block.legs.len()]
    }

    /// Upper bounds of the strengths of the steps at a corner that begin with the leg at a place among the ends that arrive there, by
    /// own leg; 0 for a leg, or empty for all, where the limits end.
    #[inline]
    pub fn strengths(&self, at: &CornerSteps, place: u32) -> &[f32] {
        if place as usize >= at.places {
            return &[];
        }
        let count = at.legs.len();
        &self.strengths[at.first_strength + place as usize * count..][..count]
    }
}
