//! Legs from corner to corner: done once a map, for paths of two and more diffractions.
//!
//! Each leg is looked at from both of its ends: a transmitter's waves leave along it at the one corner, and a receiver asks what
//! arrives along it at the other. The legs from one corner to another are a block. Blocks are what a link looks at first.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::bound::Directions;
use crate::friis::Friis;
use crate::leg_ends::LegEnds;
use crate::legs::{Corners, Legs};
use crate::ray::Ray;

/// The legs from one corner to another.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub to: u32,
    /// Index among the blocks that arrive there.
    pub arrival: u32,
    /// Range among the legs that leave the first corner.
    pub legs: Range<u32>,
    /// Slot of the first leg at the second corner.
    pub first_slot: u32,
}

/// The legs that leave a corner, sorted by the corner they reach.
#[derive(Debug, Clone, Default)]
pub(crate) struct Leaving {
    pub legs: Legs,
    /// Ray of each leg at this corner.
    pub rays: Vec<Ray>,
    pub ends: LegEnds,
    /// Index of each leg among the ends.
    pub places: Vec<u32>,
    /// The blocks that begin here, in the order of the corners that legs reach.
    pub blocks: Vec<Block>,
}

/// Legs between all corners.
#[derive(Debug, Clone, Default)]
pub(crate) struct Between {
    /// Legs, indexed by start corner.
    leaving: Vec<Leaving>,
    /// Ends of the legs, indexed by end corner.
    arriving: Vec<LegEnds>,
}

/// A leg on arrival.
#[derive(Debug, Clone, Copy)]
struct Arriving {
    from: u32,
    leg: u32,
    block: u32,
    slot: u32,
}

/// Memory that a leg takes here, besides its own.
const BYTES: usize = 2 * (Directions::BYTES + size_of::<f64>() + 2 * size_of::<u32>())
    + size_of::<Ray>()
    + size_of::<u32>();

impl Between {
    /// Finds the legs, with `slopes` those of their waves too; `legs_from` finds the legs from one corner. `Ok(None)` if they take more than
    /// `max_bytes`.
    pub fn find<E: Send>(
        corners: &Corners,
        slopes: Option<Friis>,
        max_bytes: usize,
        legs_from: impl Fn(usize) -> Result<Option<Legs>, E> + Sync,
    ) -> Result<Option<Self>, E> {
        let bytes = AtomicUsize::new(0);
        let legs = (0..corners.wedges.len())
            .into_par_iter()
            .map(|from| {
                let Some(legs) = legs_from(from)? else {
                    return Ok(None);
                };
                let more = legs.bytes() + legs.all().len() * BYTES;
                let is_too_much = bytes.fetch_add(more, Ordering::Relaxed) + more > max_bytes;
                Ok((!is_too_much).then_some(legs))
            })
            .collect::<Result<Option<Vec<Legs>>, E>>()?;
        Ok(legs.map(|legs| Self::new(corners, slopes, legs)))
    }

    fn new(corners: &Corners, slopes: Option<Friis>, legs: Vec<Legs>) -> Self {
        let mut arriving: Vec<Vec<Arriving>> = vec![Vec::new(); legs.len()];
        let mut arrived = vec![0; legs.len()];
        let blocks_from = (0..).zip(&legs).map(|(from, legs)| {
            let blocks = legs.at_corners().iter().map(|at| {
                let (arriving, arrived) = (
                    &mut arriving[at.corner as usize],
                    &mut arrived[at.corner as usize],
                );
                let block = Block {
                    to: at.corner,
                    arrival: *arrived,
                    legs: at.legs.clone(),
                    first_slot: arriving.len() as u32,
                };
                *arrived += 1;
                for (leg, slot) in block.legs.clone().zip(block.first_slot..) {
                    let block = block.arrival;
                    arriving.push(Arriving {
                        from,
                        leg,
                        block,
                        slot,
                    });
                }
                block
            });
            blocks.collect()
        });
        let blocks_from: Vec<Vec<Block>> = blocks_from.collect();
        let leaving: Vec<Leaving> = legs
            .into_par_iter()
            .zip(blocks_from)
            .enumerate()
            .map(|(from, (legs, blocks))| Leaving::new(corners, slopes, from, legs, blocks))
            .collect();
        let arriving: Vec<LegEnds> = arriving
            .into_par_iter()
            .enumerate()
            .map(|(to, mut arriving)| {
                let leg = |end: &Arriving| &leaving[end.from as usize].legs.all()[end.leg as usize];
                arriving.sort_by_key(|end| leg(end).reflections);
                let wedge = &corners.wedges[to];
                let mut ends = LegEnds::default();
                for end in &arriving {
                    let leg = leg(end);
                    let direction = wedge.direction(&leg.ray);
                    ends.push(
                        &direction,
                        leg.strength,
                        leg.reflections,
                        end.block,
                        end.slot,
                    );
                }
                ends
            })
            .collect();
        Self { leaving, arriving }
    }

    /// Most reflections on any leg.
    pub fn most_reflections(&self) -> u32 {
        let legs = self.leaving.iter();
        legs.map(|leaving| leaving.legs.most_reflections())
            .max()
            .unwrap_or(0)
    }

    /// Legs that leave a corner.
    pub fn leaving(&self, corner: u32) -> &Leaving {
        &self.leaving[corner as usize]
    }

    /// Ends of the legs that arrive at a corner.
    pub fn arriving(&self, corner: u32) -> &LegEnds {
        &self.arriving[corner as usize]
    }
}

impl Leaving {
    fn new(
        corners: &Corners,
        slopes: Option<Friis>,
        from: usize,
        mut legs: Legs,
        blocks: Vec<Block>,
    ) -> Self {
        let wedge = &corners.wedges[from];
        let rays = legs.all_mut().iter_mut().map(|leg| {
            let mut ray = wedge.ray(leg.corner_image);
            if let Some(friis) = slopes {
                ray.slope = friis.slope(leg.reflections, [&ray, &leg.ray]);
                leg.ray.slope = ray.slope;
            }
            ray
        });
        let rays: Vec<Ray> = rays.collect();
        let all = legs.all();
        let mut places = vec![0; all.len()];
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by_key(|&i| all[i].reflections);
        let mut ends = LegEnds::default();
        let block_of = (0..).zip(&blocks);
        let block_of: Vec<u32> = block_of
            .flat_map(|(number, block)| block.legs.clone().map(move |_| number))
            .collect();
        for (place, &i) in (0..).zip(&order) {
            let direction = wedge.direction(&rays[i]);
            let leg = &all[i];
            ends.push(
                &direction,
                leg.strength,
                leg.reflections,
                block_of[i],
                i as u32,
            );
            places[i] = place;
        }
        Self {
            blocks,
            legs,
            rays,
            ends,
            places,
        }
    }
}
