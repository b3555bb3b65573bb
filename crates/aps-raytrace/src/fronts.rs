//! Fronts: waves of a transmitter on arrival at their last corner before the receiver.
//!
//! With one diffraction a front is a leg of the transmitter. With more it continues a wave at the corner before along a leg between
//! corners. There are many of those and few links need any one of them: what is kept is an upper bound of each one's strength, and
//! the largest of each block. Its amplitude is computed when the first link asks.

mod blocks;

use std::ops::Range;
use std::sync::OnceLock;

use num_complex::Complex64;
use smallvec::SmallVec;

use crate::between::{Between, Leaving};
use crate::bound::Direction;
use crate::front_counts::Counts;
use crate::legs::{Corners, Leg, LegSummary, Legs};
use crate::limits::Limits;
use crate::path::{Interaction, InteractionKind, Interactions};
use crate::ray::Ray;
use crate::strength::{Bound, CornerStrengths, RowSum, Rows, Strength, Table};

pub(crate) use blocks::{BlockFronts, Blocks};

/// Marker of a front that continues no wave: a leg of the transmitter.
const NO_WAVE: u32 = u32::MAX;

/// A front: the wave that it continues, and the leg.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrontId {
    wave: u32,
    leg: u32,
}

impl FrontId {
    /// The front of a leg of the transmitter.
    pub fn own(leg: u32) -> Self {
        Self { wave: NO_WAVE, leg }
    }

    /// The front along a leg that leaves the corner of a wave.
    pub fn after(wave: u32, leg: u32) -> Self {
        Self { wave, leg }
    }
}

/// The amplitude of a front.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Amplitude {
    pub value: Complex64,
    /// Derivative of the value by the angle at the corner before, times mu of [`crate::slope`]; 0 where slopes are not taken along.
    pub slope: Complex64,
}

/// A front on arrival at a corner from which it goes on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wave {
    pub corner: u32,
    front: FrontId,
    /// Upper bound of the amplitude's magnitude.
    strength: f64,
    /// Length from the transmitter \[m\].
    pub length_m: f64,
    pub reflections: u32,
    /// Number of corners before this one.
    pub diffractions: u32,
    /// Index of the first amplitude of its fronts.
    first_front: usize,
}

/// Waves that arrive at one corner after equally many others.
#[derive(Debug, Clone)]
pub(crate) struct Group {
    corner: u32,
    waves: Range<u32>,
    /// Bounds of fronts' strengths, one row a leg, one column a wave; 0 beyond the limits.
    rows: Rows,
}

/// Fronts of one transmitter at all corners, with bounds of their strengths.
#[derive(Debug, Clone, Default)]
pub(crate) struct Fronts {
    /// Directions of the transmitter's own legs at their corners.
    own: Vec<Direction>,
    /// Waves that go on to further corners.
    waves: Vec<Wave>,
    /// Waves by number of diffractions and corner.
    groups: Vec<Group>,
    table: Table,
    /// Amplitudes by wave and place, computed when first used.
    amplitudes: Vec<OnceLock<Amplitude>>,
    blocks: Blocks,
    /// Numbers of fronts by number of diffractions before the corner where they arrive.
    counts: Vec<Counts>,
}

/// Legs and corners from which fronts are made: prepared once a map, and once a transmitter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sources<'t> {
    pub corners: &'t Corners,
    /// Legs between corners; absent if no path has two diffractions.
    pub between: Option<&'t Between>,
    /// Legs of the transmitter.
    pub legs: &'t Legs,
}

impl<'t> Sources<'t> {
    fn between(&self) -> &'t Between {
        self.between
            .expect("waves go on along legs between corners")
    }

    fn leaving(&self, wave: &Wave) -> &'t Leaving {
        self.between().leaving(wave.corner)
    }

    /// Summary of a leg that leaves the corner of a group.
    pub fn leg_after(&self, group: &Group, leg: u32) -> &'t LegSummary {
        &self
            .between()
            .leaving(group.corner)
            .legs
            .summaries(leg..leg + 1)[0]
    }
}

/// Memory of [`Fronts::extend`].
#[derive(Debug, Default)]
struct Memory {
    corner_strengths: CornerStrengths,
    /// Strengths of the blocks that begin at a corner.
    strengths: Vec<Strength>,
    /// Blocks and the corners where they end.
    blocks: Vec<(u32, BlockFronts)>,
}

impl Fronts {
    /// Extends the transmitter's legs corner by corner. `None` if the fronts take more than the limit.
    pub fn extend(of: &Sources<'_>, limits: &Limits) -> Option<Self> {
        let mut fronts = Self::default();
        let corners = of.corners.wedges.len();
        let mut reflections = of.legs.most_reflections().min(limits.reflections);
        let mut counts = Counts::new(corners, reflections);
        let mut level = Vec::new();
        for (i, leg) in (0..).zip(of.legs.all()) {
            let wedge = &of.corners.wedges[leg.corner as usize];
            fronts.own.push(wedge.direction(&leg.ray));
            if limits.allow(leg.reflections, 1) {
                counts.at(leg.corner)[leg.reflections as usize] += 1;
                level.push(Wave {
                    corner: leg.corner,
                    front: FrontId::own(i),
                    strength: leg.strength,
                    length_m: leg.ray.length_m,
                    reflections: leg.reflections,
                    diffractions: 0,
                    first_front: 0,
                });
            }
        }
        counts.sum_up();
        fronts.counts.push(counts);
        let Some(between) = of.between else {
            return Some(fronts);
        };
        let mut memory = Memory::default();
        for diffractions in 1..limits.diffractions {
            reflections = (reflections + between.most_reflections()).min(limits.reflections);
            let mut counts = Counts::new(corners, reflections);
            let mut next = Vec::new();
            for waves in level.chunk_by(|p, q| p.corner == q.corner) {
                fronts.add(of, limits, waves, &mut counts, &mut memory)?;
                if diffractions + 1 < limits.diffractions {
                    fronts.go_on(of, limits, &mut next)?;
                }
            }
            counts.sum_up();
            fronts.counts.push(counts);
            next.sort_by_key(|wave: &Wave| wave.corner);
            level = next;
        }
        fronts.blocks = Blocks::new(memory.blocks, corners);
        Some(fronts)
    }

    /// Adds waves at one corner and the fronts that continue them.
    fn add(
        &mut self,
        of: &Sources<'_>,
        limits: &Limits,
        waves: &[Wave],
        counts: &mut Counts,
        memory: &mut Memory,
    ) -> Option<()> {
        let corner = waves[0].corner;
        let leaving = of.between().leaving(corner);
        let wedge = &of.corners.wedges[corner as usize];
        let ends = &leaving.ends;
        let count = |wave: &Wave| {
            let left = limits.left(wave.reflections, wave.diffractions + 2);
            left.map_or(0, |left| ends.with_at_most(left))
        };
        let fronts: usize = waves.iter().map(count).sum();
        let bytes = self.table.bytes()
            + ends.slots.len() * Table::row_bytes(waves.len())
            + (self.amplitudes.len() + fronts) * size_of::<OnceLock<Amplitude>>()
            + (self.waves.len() + waves.len()) * size_of::<Wave>()
            + (memory.blocks.len() + leaving.blocks.len()) * size_of::<(u32, BlockFronts)>();
        if bytes > limits.bytes {
            return None;
        }
        let first_wave = self.waves.len() as u32;
        let rows = self.table.add(ends.slots.len(), waves.len());
        let Memory {
            corner_strengths,
            strengths,
            blocks,
        } = memory;
        corner_strengths.clear(ends.slots.len());
        strengths.clear();
        strengths.resize(ends.block_count, Strength::default());
        for (kind, wave) in waves.iter().enumerate() {
            let count = count(wave);
            let direction = wedge.direction(self.ray(of, wave.front));
            let strength = |place: usize| wave.strength * ends.strengths[place];
            let table = (&mut self.table, rows, kind);
            corner_strengths.add((&wedge.bound, &direction), (ends, count), strength, table);
            self.waves.push(Wave {
                first_front: self.amplitudes.len(),
                ..*wave
            });
            let amplitudes = self.amplitudes.len() + count;
            self.amplitudes.resize_with(amplitudes, OnceLock::new);
        }
        let group = self.groups.len() as u32;
        self.groups.push(Group {
            corner,
            waves: first_wave..self.waves.len() as u32,
            rows,
        });
        corner_strengths.finish(ends, (&mut self.table, rows), |place, strength| {
            strengths[ends.blocks[place] as usize].add(&strength);
        });
        for (block, &strength) in leaving.blocks.iter().zip(&*strengths) {
            if strength.max > 0.0 {
                let fronts = BlockFronts {
                    arrival: block.arrival,
                    group,
                    strength,
                    rest_power: 0.0,
                    first_leg: block.legs.start,
                    first_slot: block.first_slot,
                    legs: block.legs.len() as u32,
                };
                blocks.push((block.to, fronts));
            }
        }
        // Waves of equally many reflections at once.
        let diffractions = waves[0].diffractions + 1;
        let mut kinds: SmallVec<[(u32, usize); 8]> = SmallVec::new();
        for wave in waves {
            match kinds.iter_mut().find(|kind| kind.0 == wave.reflections) {
                Some(kind) => kind.1 += 1,
                None => kinds.push((wave.reflections, 1)),
            }
        }
        for at_end in leaving.legs.counts() {
            let at_corner = counts.at(at_end.corner);
            for &(reflections, waves) in &kinds {
                let reflections = reflections + at_end.reflections;
                if limits.allow(reflections, diffractions + 1) {
                    at_corner[reflections as usize] += waves * at_end.legs;
                }
            }
        }
        Some(())
    }

    /// Adds the waves that the fronts of the last group become at further corners.
    fn go_on(&self, of: &Sources<'_>, limits: &Limits, out: &mut Vec<Wave>) -> Option<()> {
        let group = self.groups.last()?;
        let leaving = of.between().leaving(group.corner);
        let legs = leaving.legs.all();
        for (i, leg) in (0..).zip(legs) {
            let strengths = self.along_leg(group, i);
            for ((id, wave), strength) in self.waves_of(group).zip(strengths) {
                let reflections = wave.reflections + leg.reflections;
                if !limits.allow(reflections, wave.diffractions + 2) {
                    continue;
                }
                if (out.len() + 1) * size_of::<Wave>() > limits.bytes {
                    return None;
                }
                out.push(Wave {
                    corner: leg.corner,
                    front: FrontId::after(id, i),
                    strength: strength.get(),
                    length_m: wave.length_m + leg.ray.length_m,
                    reflections,
                    diffractions: wave.diffractions + 1,
                    first_front: 0,
                });
            }
        }
        Some(())
    }

    fn last_leg<'t>(&self, of: &Sources<'t>, front: FrontId) -> (&'t Legs, &'t Leg) {
        let legs = match self.waves.get(front.wave as usize) {
            Some(wave) => &of.leaving(wave).legs,
            None => of.legs,
        };
        (legs, &legs.all()[front.leg as usize])
    }

    /// Ray at a front's corner, back along its last leg.
    pub fn ray<'t>(&self, of: &Sources<'t>, front: FrontId) -> &'t Ray {
        &self.last_leg(of, front).1.ray
    }

    /// Number of fronts.
    pub fn len(&self) -> usize {
        self.counts.iter().map(Counts::total).sum()
    }

    /// Number of fronts at a corner that make a path within the limits with a last leg of this many reflections.
    #[inline]
    pub fn paths(&self, corner: u32, reflections: u32, limits: &Limits) -> usize {
        let fronts = (1..).zip(&self.counts).map(|(diffractions, counts)| {
            let left = limits.left(reflections, diffractions);
            left.map_or(0, |left| counts.with_at_most(corner, left))
        });
        fronts.sum()
    }

    /// Directions of the transmitter's own legs.
    pub fn own(&self) -> &[Direction] {
        &self.own
    }

    /// The fronts by block but for the transmitter's own legs.
    pub fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    /// Returns a group by its number.
    #[inline]
    pub fn group(&self, number: u32) -> &Group {
        &self.groups[number as usize]
    }

    /// Waves of a group, in order.
    pub fn waves_of(&self, group: &Group) -> impl Iterator<Item = (u32, &Wave)> {
        let range = group.waves.start as usize..group.waves.end as usize;
        group.waves.clone().zip(&self.waves[range])
    }

    /// Maximum and sum of squares of the fronts along each of the legs of a block; all 0 beyond the limits.
    #[inline]
    pub fn sums(&self, block: &BlockFronts) -> &[RowSum] {
        let rows = self.group(block.group).rows;
        self.table
            .sums(rows, block.first_leg..block.first_leg + block.legs)
    }

    /// Strengths of the fronts that continue the waves of a group along a leg, by wave.
    #[inline]
    pub fn along_leg(&self, group: &Group, leg: u32) -> &[Bound] {
        self.table.row(group.rows, leg)
    }

    /// Product of the reflection and diffraction coefficients so far, over the square root of the product of all leg lengths.
    pub fn amplitude(&self, of: &Sources<'_>, front: FrontId) -> Amplitude {
        let (_, leg) = self.last_leg(of, front);
        let Some(wave) = self.waves.get(front.wave as usize) else {
            return Amplitude {
                value: leg.coefficient / leg.ray.length_m.sqrt(),
                slope: Complex64::ZERO,
            };
        };
        let leaving = of.leaving(wave);
        let place = leaving.places[front.leg as usize] as usize;
        *self.amplitudes[wave.first_front + place].get_or_init(|| {
            let wedge = &of.corners.wedges[wave.corner as usize];
            let out = &leaving.rays[front.leg as usize];
            let before = self.ray(of, wave.front);
            let amplitude = self.amplitude(of, wave.front);
            if out.slope == 0.0 {
                let coefficient = wedge.coefficient(before, out);
                return Amplitude {
                    value: amplitude.value * coefficient * leg.coefficient
                        / leg.ray.length_m.sqrt(),
                    slope: Complex64::ZERO,
                };
            }
            let matrix = wedge.matrix(before, out);
            let Amplitude { value, slope } = amplitude;
            let leg_factor = leg.coefficient / leg.ray.length_m.sqrt();
            let mu = Complex64::new(0.0, out.slope);
            Amplitude {
                value: (value * matrix.value + slope * matrix.by_first) * leg_factor,
                slope: (value * matrix.by_second + slope * matrix.by_both) * leg_factor * mu,
            }
        })
    }

    /// Length of a front from the transmitter \[m\].
    pub fn length_m(&self, of: &Sources<'_>, front: FrontId) -> f64 {
        let before = self.waves.get(front.wave as usize);
        before.map_or(0.0, |wave| wave.length_m) + self.last_leg(of, front).1.ray.length_m
    }

    /// The transmitter's own leg that a front begins with.
    pub fn own_leg(&self, mut front: FrontId) -> usize {
        while let Some(wave) = self.waves.get(front.wave as usize) {
            front = wave.front;
        }
        front.leg as usize
    }

    /// Appends the interactions on the way of a front, its corner included.
    pub fn interactions(&self, of: &Sources<'_>, front: FrontId, path: &mut Interactions) {
        if let Some(wave) = self.waves.get(front.wave as usize) {
            self.interactions(of, wave.front, path);
        }
        let (legs, leg) = self.last_leg(of, front);
        path.extend_from_slice(legs.reflections_of(leg));
        let wedge = &of.corners.wedges[leg.corner as usize];
        path.push(Interaction {
            kind: InteractionKind::Diffraction,
            id: wedge.id,
            point: wedge.point,
        });
    }
}
