//! Last steps: what a receiver adds to the waves at the corners it sees.
//!
//! A last step begins with a leg between corners, turns at the corner that the receiver sees, and ends with one of the receiver's
//! legs. As with fronts, an upper bound of the strength of each is kept, and the largest of each block.

use std::ops::Range;

use crate::between::Between;
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
}

/// All last steps of one receiver.
#[derive(Debug, Clone, Default)]
pub(crate) struct LastSteps {
    /// The receiver's own legs as seen at their corners.
    own: Vec<Direction>,
    /// By own leg, then by place among the ends that arrive at its corner, as far as the limits allow: |D| times the strength of the
    /// own leg, or more.
    strengths: Vec<f32>,
    /// First step of each own leg.
    first: Vec<usize>,
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
        let mut rows = Rows::default();
        let mut blocks = vec![Strength::default(); between.blocks().len()];
        for legs in legs.all().chunk_by(|p, q| p.corner == q.corner) {
            let corner = legs[0].corner;
            let wedge = &corners.wedges[corner as usize].bound;
            let ends = between.arriving(corner);
            rows.clear(ends.blocks.len());
            for leg in legs {
                let left = limits.left(leg.reflections, 2);
                let count = left.map_or(0, |left| ends.with_at_most(left));
                let first = steps.strengths.len();
                let bytes = (first + count) * size_of::<f32>()
                    + (steps.blocks.len() + ends.blocks.len()) * size_of::<BlockSteps>();
                if bytes > limits.bytes {
                    return None;
                }
                let own = &steps.own[steps.first.len()];
                let bounds = rows.bounds(wedge, own, &ends.directions, count);
                bounds.iter_mut().for_each(|bound| *bound *= leg.strength);
                let bounds = bounds.iter().map(|&bound| rounded_up(bound));
                steps.strengths.extend(bounds);
                steps.first.push(first);
                rows.add();
            }
            rows.into_blocks(&ends.blocks, &mut blocks);
            steps.add_corner(corner, &ends.blocks, &mut blocks);
        }
        Some(steps)
    }

    /// Moves what was added to some blocks here.
    fn add_corner(&mut self, corner: u32, ids: &[u32], strengths: &mut [Strength]) {
        let first = self.blocks.len();
        for &block in ids {
            let strength = std::mem::take(&mut strengths[block as usize]);
            if strength.max > 0.0 {
                self.blocks.push(BlockSteps {
                    block,
                    strength,
                    rest_power: 0.0,
                });
            }
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
        self.corners.push(CornerSteps {
            corner,
            strength: all,
            blocks: first..self.blocks.len(),
        });
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

    /// Upper bound of the strength of the step that ends with an own leg and begins with the leg at a place among the ends that
    /// arrive at its corner.
    #[inline]
    pub fn strength(&self, own_leg: usize, place: u32) -> f64 {
        self.strengths[self.first[own_leg] + place as usize].into()
    }
}
