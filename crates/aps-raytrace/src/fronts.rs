//! Fronts: waves of a transmitter on arrival at their last corner before the receiver.
//!
//! With one diffraction a front is a leg. With more, each front is a leg between two corners that
//! continues an earlier front; the coefficients of all corners but the last are already in it.
//! A link only adds the last one.

use num_complex::Complex64;

use crate::legs::{Corners, Leg, Legs};
use crate::path::{Interaction, InteractionKind, Interactions};
use crate::wedge::Ray;

/// Marks a front that starts at the transmitter.
const NO_PARENT: u32 = u32::MAX;

/// A wave on arrival at a corner.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Front {
    /// At the corner, back along the last leg.
    pub ray: Ray,
    /// Reflection and diffraction coefficients so far, over the square root of the product of
    /// all leg lengths.
    pub amplitude: Complex64,
    /// Magnitude of it.
    pub strength: f64,
    /// Length from the transmitter \[m\].
    pub length_m: f64,
    pub reflections: u32,
    /// Corners before this one.
    pub diffractions: u32,
    corner: u32,
    /// Its last leg: of the transmitter, or of the corner before.
    leg: u32,
    parent: u32,
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
}

/// All fronts of one transmitter, by corner.
#[derive(Debug, Clone, Default)]
pub(crate) struct Fronts {
    fronts: Vec<Front>,
    /// Fronts sorted by corner.
    order: Vec<u32>,
    /// First of each corner in `order`, and the end.
    first: Vec<u32>,
}

impl Fronts {
    /// Extends the transmitter's legs corner by corner. `between` holds the legs from each corner
    /// to all others; it may be empty when at most one diffraction is allowed. `None` if the fronts
    /// take more than the limit.
    pub fn extend(
        corners: &Corners,
        legs: &Legs,
        between: &[Legs],
        limits: &Limits,
    ) -> Option<Self> {
        let most = limits.bytes / size_of::<Front>();
        let mut fronts: Vec<Front> = legs
            .all()
            .iter()
            .zip(0..)
            .filter(|(leg, _)| limits.allow(leg.reflections, 1))
            .map(|(leg, i)| Front {
                ray: leg.ray,
                amplitude: leg.coefficient / leg.ray.length_m.sqrt(),
                strength: leg.strength,
                length_m: leg.ray.length_m,
                reflections: leg.reflections,
                diffractions: 0,
                corner: leg.corner,
                leg: i,
                parent: NO_PARENT,
            })
            .collect();
        let mut begin = 0;
        for diffractions in 1..limits.diffractions {
            let end = fronts.len();
            for parent in begin..end {
                let before = fronts[parent];
                let wedge = &corners.wedges[before.corner as usize];
                for (leg, i) in between[before.corner as usize].all().iter().zip(0..) {
                    let reflections = before.reflections + leg.reflections;
                    if !limits.allow(reflections, diffractions + 1) {
                        continue;
                    }
                    if fronts.len() >= most {
                        return None;
                    }
                    let out = wedge.ray(leg.corner_image);
                    let amplitude =
                        before.amplitude * wedge.coefficient(&before.ray, &out) * leg.coefficient
                            / leg.ray.length_m.sqrt();
                    fronts.push(Front {
                        ray: leg.ray,
                        amplitude,
                        strength: amplitude.norm(),
                        length_m: before.length_m + leg.ray.length_m,
                        reflections,
                        diffractions,
                        corner: leg.corner,
                        leg: i,
                        parent: parent as u32,
                    });
                }
            }
            begin = end;
        }
        let mut order: Vec<u32> = (0..fronts.len() as u32).collect();
        order.sort_by_key(|&i| fronts[i as usize].corner);
        let mut first = vec![0_u32; corners.wedges.len() + 1];
        for front in &fronts {
            first[front.corner as usize + 1] += 1;
        }
        for c in 0..corners.wedges.len() {
            first[c + 1] += first[c];
        }
        Some(Self {
            fronts,
            order,
            first,
        })
    }

    /// Fronts at one corner.
    #[inline]
    pub fn at(&self, corner: usize) -> impl Iterator<Item = (u32, &Front)> {
        let range = match self.first.get(corner..corner + 2) {
            Some(&[from, to]) => from as usize..to as usize,
            _ => 0..0,
        };
        self.order[range]
            .iter()
            .map(|&i| (i, &self.fronts[i as usize]))
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.fronts.len()
    }

    /// The interactions of the path along `front` and `last`, the receiver's leg to its corner.
    pub fn interactions(
        &self,
        corners: &Corners,
        legs: &Legs,
        between: &[Legs],
        front: u32,
        last: (&Legs, &Leg),
    ) -> Interactions {
        let mut path = Interactions::new();
        // Backwards from the corner to the transmitter, then turned around.
        let mut at = &self.fronts[front as usize];
        loop {
            let wedge = &corners.wedges[at.corner as usize];
            path.push(Interaction {
                kind: InteractionKind::Diffraction,
                id: wedge.id,
                point: wedge.point,
            });
            let parent = self.fronts.get(at.parent as usize);
            let from = parent.map_or(legs, |p| &between[p.corner as usize]);
            let leg = &from.all()[at.leg as usize];
            path.extend(from.reflections_of(leg).iter().rev().copied());
            match parent {
                Some(parent) => at = parent,
                None => break,
            }
        }
        path.reverse();
        let (legs, leg) = last;
        path.extend(legs.reflections_of(leg).iter().rev().copied());
        path
    }
}
