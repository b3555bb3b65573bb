//! Fronts: waves of a transmitter on arrival at their last corner before the receiver.
//!
//! With one diffraction a front is a leg of the transmitter. With more it continues a wave at the corner before along a leg between
//! corners. There are many of those and few links need any one of them: what is kept is an upper bound of each one's strength, and
//! the largest of each block. Its amplitude is computed when the first link asks.

use std::sync::OnceLock;

use num_complex::Complex64;

use crate::between::{Between, Leaving};
use crate::bound::{Directions, rounded_up};
use crate::legs::{Corners, Leg, Legs};
use crate::path::{Interaction, InteractionKind, Interactions};
use crate::strength::{Rows, Strength};
use crate::wedge::Ray;

/// Instead of a wave: none, as a leg of the transmitter continues none.
const NO_WAVE: u32 = u32::MAX;

/// A front: the wave that it continues, and the leg.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrontId {
    wave: u32,
    leg: u32,
}

impl FrontId {
    /// A leg of the transmitter.
    pub fn own(leg: u32) -> Self {
        Self { wave: NO_WAVE, leg }
    }

    /// A leg that leaves the corner of a wave.
    pub fn after(wave: u32, leg: u32) -> Self {
        Self { wave, leg }
    }
}

/// What may be on a path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    pub reflections: u32,
    pub diffractions: u32,
    pub interactions: u32,
    /// Memory that the waves of one terminal may take.
    pub bytes: usize,
}

impl Limits {
    /// Whether a path with these numbers stays inside.
    #[inline]
    pub fn allow(&self, reflections: u32, diffractions: u32) -> bool {
        reflections <= self.reflections
            && diffractions <= self.diffractions
            && reflections + diffractions <= self.interactions
    }

    /// How many more reflections a path with these numbers may have.
    #[inline]
    pub fn left(&self, reflections: u32, diffractions: u32) -> Option<u32> {
        let most = self.interactions.checked_sub(diffractions)?;
        let left = self.reflections.min(most).checked_sub(reflections)?;
        (diffractions <= self.diffractions).then_some(left)
    }
}

/// A front on arrival at a corner from which it goes on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wave {
    pub corner: u32,
    front: FrontId,
    /// Upper bound of the magnitude of its amplitude.
    strength: f64,
    /// Length from the transmitter \[m\].
    pub length_m: f64,
    pub reflections: u32,
    /// Corners before this one.
    pub diffractions: u32,
    /// Its first front, one for each leg that leaves the corner.
    first_front: usize,
}

/// How many fronts of one kind arrive at a corner.
#[derive(Debug, Clone, Copy)]
struct Count {
    reflections: u32,
    diffractions: u32,
    fronts: usize,
}

/// All fronts of one transmitter.
#[derive(Debug, Clone, Default)]
pub(crate) struct Fronts {
    /// The transmitter's own legs as seen at their corners.
    own: Directions,
    /// Waves that go on to further corners.
    waves: Vec<Wave>,
    /// Sorted by corner.
    order: Vec<u32>,
    /// First of each corner in `order`, and the end.
    first_wave: Vec<u32>,
    /// Upper bounds of the strengths of the fronts that continue the waves; 0 beyond the limits.
    strengths: Vec<f32>,
    amplitudes: Vec<OnceLock<Complex64>>,
    /// By block, and by the corner where it ends.
    blocks: Vec<Strength>,
    corners: Vec<Strength>,
    /// By corner.
    counts: Vec<Vec<Count>>,
}

/// What fronts are made of: done once a map, and once a transmitter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sources<'t> {
    pub corners: &'t Corners,
    /// None where no path has two diffractions.
    pub between: Option<&'t Between>,
    /// The transmitter's.
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
}

impl Fronts {
    /// Extends the transmitter's legs corner by corner. `None` if the fronts take more than the limit.
    pub fn extend(of: &Sources<'_>, limits: &Limits) -> Option<Self> {
        let mut fronts = Self {
            counts: vec![Vec::new(); of.corners.wedges.len()],
            ..Self::default()
        };
        let mut level = Vec::new();
        for (i, leg) in (0..).zip(of.legs.all()) {
            let wedge = &of.corners.wedges[leg.corner as usize];
            fronts.own.push(&wedge.bound.direction(&leg.ray));
            if limits.allow(leg.reflections, 1) {
                fronts.count(leg.corner, leg.reflections, 0);
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
        let Some(between) = of.between else {
            return Some(fronts);
        };
        fronts.blocks = vec![Strength::default(); between.blocks().len()];
        let mut rows = Rows::default();
        for diffractions in 1..limits.diffractions {
            let mut next = Vec::new();
            for waves in level.chunk_by(|p, q| p.corner == q.corner) {
                let first = fronts.waves.len() as u32;
                fronts.add(of, limits, waves, &mut rows)?;
                for id in first..fronts.waves.len() as u32 {
                    if diffractions + 1 < limits.diffractions {
                        fronts.go_on(of, limits, id, &mut next)?;
                    }
                }
            }
            next.sort_by_key(|wave: &Wave| wave.corner);
            level = next;
        }
        fronts.sort(of.corners.wedges.len());
        fronts.corners = vec![Strength::default(); of.corners.wedges.len()];
        for (block, strength) in between.blocks().iter().zip(&fronts.blocks) {
            fronts.corners[block.to as usize].add(strength);
        }
        Some(fronts)
    }

    /// Adds waves at one corner and the fronts that continue them.
    fn add(
        &mut self,
        of: &Sources<'_>,
        limits: &Limits,
        waves: &[Wave],
        rows: &mut Rows,
    ) -> Option<()> {
        let corner = waves[0].corner;
        let leaving = of.between().leaving(corner);
        let wedge = &of.corners.wedges[corner as usize].bound;
        let ends = &leaving.ends;
        rows.clear(ends.blocks.len());
        for wave in waves {
            let left = limits.left(wave.reflections, wave.diffractions + 2);
            let count = left.map_or(0, |left| ends.with_at_most(left));
            let first = self.strengths.len();
            let entry = size_of::<f32>() + size_of::<OnceLock<Complex64>>();
            let wave_bytes = (self.waves.len() + 1) * size_of::<Wave>();
            if (first + count) * entry + wave_bytes > limits.bytes {
                return None;
            }
            let direction = wedge.direction(self.ray(of, wave.front));
            let bounds = rows.bounds(wedge, &direction, &ends.directions, count);
            for (bound, strength) in bounds.iter_mut().zip(&ends.strengths) {
                *bound *= wave.strength * strength;
            }
            self.strengths.extend(bounds.iter().map(|&b| rounded_up(b)));
            self.amplitudes.resize_with(first + count, OnceLock::new);
            rows.add();
            self.waves.push(Wave {
                first_front: first,
                ..*wave
            });
        }
        rows.into_blocks(&ends.blocks, &mut self.blocks);
        for leg in leaving.legs.all() {
            for wave in waves {
                let reflections = wave.reflections + leg.reflections;
                if limits.allow(reflections, wave.diffractions + 2) {
                    self.count(leg.corner, reflections, wave.diffractions + 1);
                }
            }
        }
        Some(())
    }

    /// The waves that its fronts become at further corners.
    fn go_on(&self, of: &Sources<'_>, limits: &Limits, id: u32, out: &mut Vec<Wave>) -> Option<()> {
        let wave = &self.waves[id as usize];
        for (i, leg) in (0..).zip(of.leaving(wave).legs.all()) {
            let reflections = wave.reflections + leg.reflections;
            if !limits.allow(reflections, wave.diffractions + 2) {
                continue;
            }
            if (out.len() + 1) * size_of::<Wave>() > limits.bytes {
                return None;
            }
            let place = of.leaving(wave).places[i as usize][0] as usize;
            out.push(Wave {
                corner: leg.corner,
                front: FrontId::after(id, i),
                strength: self.strengths[wave.first_front + place].into(),
                length_m: wave.length_m + leg.ray.length_m,
                reflections,
                diffractions: wave.diffractions + 1,
                first_front: 0,
            });
        }
        Some(())
    }

    fn count(&mut self, corner: u32, reflections: u32, diffractions: u32) {
        let counts = &mut self.counts[corner as usize];
        let is_same =
            |c: &&mut Count| (c.reflections, c.diffractions) == (reflections, diffractions);
        match counts.iter_mut().find(is_same) {
            Some(count) => count.fronts += 1,
            None => counts.push(Count {
                reflections,
                diffractions,
                fronts: 1,
            }),
        }
    }

    fn sort(&mut self, corners: usize) {
        let mut order: Vec<u32> = (0..self.waves.len() as u32).collect();
        order.sort_by_key(|&i| self.waves[i as usize].corner);
        self.first_wave = vec![0; corners + 1];
        for wave in &self.waves {
            self.first_wave[wave.corner as usize + 1] += 1;
        }
        for c in 0..corners {
            self.first_wave[c + 1] += self.first_wave[c];
        }
        self.order = order;
    }

    fn last_leg<'t>(&self, of: &Sources<'t>, front: FrontId) -> (&'t Legs, &'t Leg) {
        let legs = match self.waves.get(front.wave as usize) {
            Some(wave) => &of.leaving(wave).legs,
            None => of.legs,
        };
        (legs, &legs.all()[front.leg as usize])
    }

    /// At a front's corner, back along its last leg.
    pub fn ray<'t>(&self, of: &Sources<'t>, front: FrontId) -> &'t Ray {
        &self.last_leg(of, front).1.ray
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.counts.iter().flatten().map(|c| c.fronts).sum()
    }

    /// How many of those at a corner make a path with a last leg of so many reflections.
    pub fn paths(&self, corner: u32, reflections: u32, limits: &Limits) -> usize {
        let counts = self.counts[corner as usize].iter();
        counts
            .filter(|c| limits.allow(c.reflections + reflections, c.diffractions + 1))
            .map(|c| c.fronts)
            .sum()
    }

    /// Directions of the transmitter's own legs.
    pub fn own(&self) -> &Directions {
        &self.own
    }

    /// Strength of the fronts at a corner but for the transmitter's own legs.
    pub fn corner(&self, corner: u32) -> &Strength {
        &self.corners[corner as usize]
    }

    /// Strength of the fronts of a block.
    pub fn block(&self, id: u32) -> &Strength {
        &self.blocks[id as usize]
    }

    /// Waves at a corner that go on to further ones.
    pub fn waves_at(&self, corner: u32) -> impl Iterator<Item = (u32, &Wave)> {
        let [from, to] = [0, 1].map(|i| self.first_wave[corner as usize + i] as usize);
        let order = self.order[from..to].iter();
        order.map(|&i| (i, &self.waves[i as usize]))
    }

    /// Upper bound of the strength of the one that continues a wave along the leg at a place among the ends at its corner.
    #[inline]
    pub fn strength(&self, wave: &Wave, place: u32) -> f64 {
        self.strengths[wave.first_front + place as usize].into()
    }

    /// Reflection and diffraction coefficients so far, over the square root of the product of all leg lengths.
    pub fn amplitude(&self, of: &Sources<'_>, front: FrontId) -> Complex64 {
        let (_, leg) = self.last_leg(of, front);
        let Some(wave) = self.waves.get(front.wave as usize) else {
            return leg.coefficient / leg.ray.length_m.sqrt();
        };
        let leaving = of.leaving(wave);
        let place = leaving.places[front.leg as usize][0] as usize;
        *self.amplitudes[wave.first_front + place].get_or_init(|| {
            let wedge = &of.corners.wedges[wave.corner as usize];
            let out = &leaving.rays[front.leg as usize];
            let coefficient = wedge.coefficient(self.ray(of, wave.front), out);
            self.amplitude(of, wave.front) * coefficient * leg.coefficient / leg.ray.length_m.sqrt()
        })
    }

    /// Length of a front from the transmitter \[m\].
    pub fn length_m(&self, of: &Sources<'_>, front: FrontId) -> f64 {
        let before = self.waves.get(front.wave as usize);
        before.map_or(0.0, |wave| wave.length_m) + self.last_leg(of, front).1.ray.length_m
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
