//! Legs: everything between one point and the corners it reaches without diffraction.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::chain::{self, Chain};
use crate::images::{ImageTree, Visibility, VisibleWall, VisibleWallColumns};
use crate::material::Reflector;
use crate::path::{self, Interaction};
use crate::ray::Ray;
use crate::scene::Scene;
use crate::strength::Strength;
use crate::wedge::Wedge;

/// Corners of a scene that diffract, and the walls that each sees: prepared once a map.
#[derive(Debug, Clone, Default)]
pub(crate) struct Corners {
    pub wedges: Vec<Wedge>,
    visible: VisibleWallColumns,
}

impl Corners {
    /// Finds the corners; `with_visible_walls`: the walls they see too, which only reflections need. `None` if these take more than
    /// `max_bytes`.
    pub fn new(
        scene: &Scene,
        reflectors: &[Reflector],
        wavenumber_per_m: f64,
        with_visible_walls: bool,
        max_bytes: usize,
    ) -> Option<Self> {
        let wedges = scene.wedges(reflectors, wavenumber_per_m);
        let bytes = AtomicUsize::new(0);
        let seen: Vec<Vec<VisibleWall>> = wedges
            .par_iter()
            .map_init(Visibility::default, |visibility, wedge| {
                // Once there are too many, none are of use: which are found depends on the threads, that there are too many does not.
                if !with_visible_walls || bytes.load(Ordering::Relaxed) > max_bytes {
                    return Vec::new();
                }
                visibility.look(scene, wedge.point);
                // Its own building hides what lies behind it.
                visibility.hide(|window| {
                    let wall = &scene.walls()[window.wall as usize];
                    [window.lo, window.hi]
                        .iter()
                        .all(|&s| wedge.is_inside(wall.a + wall.along() * s))
                });
                let seen = visibility.visible_walls(scene);
                bytes.fetch_add(seen.len() * VisibleWallColumns::BYTES, Ordering::Relaxed);
                seen
            })
            .collect();
        if bytes.into_inner() > max_bytes {
            return None;
        }
        let visible = VisibleWallColumns::new(&seen, scene.walls().len());
        Some(Self { wedges, visible })
    }
}

/// A way from a point to a corner, by reflections or straight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leg {
    /// Index into [`Corners::wedges`].
    pub corner: u32,
    /// Ray at the corner, towards the point.
    pub ray: Ray,
    /// The corner as seen from the point \[m\].
    pub corner_image: DVec2,
    /// Product of the reflection coefficients.
    pub coefficient: Complex64,
    /// Magnitude of `coefficient` over the square root of the length: for bounds.
    pub strength: f64,
    first_reflection: u32,
    pub reflections: u32,
}

/// Summary of a leg for the search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LegSummary {
    pub length_m: f64,
    pub strength: f64,
    pub reflections: u32,
}

/// The legs to one corner.
#[derive(Debug, Clone)]
pub(crate) struct AtCorner {
    pub corner: u32,
    pub legs: Range<u32>,
    pub strength: Strength,
}

/// Number of legs to one corner by reflections.
#[derive(Debug, Clone)]
pub(crate) struct LegCount {
    pub corner: u32,
    pub reflections: u32,
    pub legs: usize,
}

/// Distance \[m\] below which two points are one: squares of distances, and powers over them, must stay numbers.
pub(crate) const NEAREST_M: f64 = 1e-100;

/// Legs of one point, sorted by corner, then by reflections.
#[derive(Debug, Clone, Default)]
pub(crate) struct Legs {
    legs: Vec<Leg>,
    summaries: Vec<LegSummary>,
    reflections: Vec<Interaction>,
    /// The corners that there are legs to.
    at: Vec<AtCorner>,
    counts: Vec<LegCount>,
}

impl Legs {
    /// Finds the legs: `tree` holds the images of the point that `visibility` is of, `own` is the corner that it is, if it is one.
    /// `None` if they take more than `max_bytes`.
    pub fn find(
        scene: &Scene,
        reflectors: &[Reflector],
        corners: &Corners,
        own: Option<&Wedge>,
        visibility: &Visibility,
        tree: &ImageTree,
        max_bytes: usize,
    ) -> Option<Self> {
        let mut found = Self::default();
        let from = visibility.from;
        let candidates = tree.candidates(&corners.visible, max_bytes)?;
        let mut candidates = candidates.into_iter().peekable();
        let leaves = |chain: &Chain| own.is_none_or(|wedge| !wedge.is_inside(chain.far_image));
        for (c, wedge) in (0..).zip(&corners.wedges) {
            let first = found.legs.len() as u32;
            let to = wedge.point;
            let direct = Chain::direct(from, to);
            if from.distance(to) >= NEAREST_M && leaves(&direct) && visibility.sees(scene, to) {
                found.push(c, wedge, from, direct);
            }
            while let Some((_, image)) = candidates.next_if(|candidate| candidate.0 == c) {
                let chain = chain::resolve(scene, reflectors, tree, image, from, to);
                if let Some(chain) = chain.filter(leaves) {
                    found.push(c, wedge, tree.images[image as usize].point, chain);
                }
                if found.bytes() > max_bytes {
                    return None;
                }
            }
            let mut strength = Strength::default();
            for leg in &found.summaries[first as usize..] {
                strength.add(&Strength::of(leg.strength));
            }
            let legs = first..found.legs.len() as u32;
            if !legs.is_empty() {
                let same = |p: &LegSummary, q: &LegSummary| p.reflections == q.reflections;
                let counts = found.summaries[first as usize..]
                    .chunk_by(same)
                    .map(|legs| LegCount {
                        corner: c,
                        reflections: legs[0].reflections,
                        legs: legs.len(),
                    });
                found.counts.extend(counts);
                found.at.push(AtCorner {
                    corner: c,
                    legs,
                    strength,
                });
            }
        }
        found.counts.shrink_to_fit();
        Some(found)
    }

    /// Memory they take, with the directions of [`Self::azimuths_rad`].
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.legs)
            + size_of_val(&*self.summaries)
            + size_of_val(&*self.reflections)
            + size_of_val(&*self.counts)
            + self.legs.len() * size_of::<f64>()
    }

    fn push(&mut self, corner: u32, wedge: &Wedge, seen_at: DVec2, chain: Chain) {
        // Through the gap between two buildings that touch at the corner.
        if wedge.is_inside(seen_at) {
            return;
        }
        let ray = wedge.ray(seen_at);
        // Off a wall that the corner lies on: no way at all.
        if ray.length_m < NEAREST_M {
            return;
        }
        let strength = chain.coefficient.norm() / ray.length_m.sqrt();
        let reflections = chain.reflections.len() as u32;
        self.summaries.push(LegSummary {
            length_m: ray.length_m,
            strength,
            reflections,
        });
        self.legs.push(Leg {
            corner,
            ray,
            corner_image: chain.far_image,
            coefficient: chain.coefficient,
            strength,
            first_reflection: self.reflections.len() as u32,
            reflections,
        });
        self.reflections.extend_from_slice(&chain.reflections);
    }

    /// The legs to all corners.
    pub fn all(&self) -> &[Leg] {
        &self.legs
    }

    /// The legs to all corners, to change.
    pub fn all_mut(&mut self) -> &mut [Leg] {
        &mut self.legs
    }

    /// Summaries of the legs.
    pub fn summaries(&self, legs: Range<u32>) -> &[LegSummary] {
        &self.summaries[legs.start as usize..legs.end as usize]
    }

    /// Most reflections on any of them.
    pub fn most_reflections(&self) -> u32 {
        let reflections = self.summaries.iter().map(|leg| leg.reflections);
        reflections.max().unwrap_or(0)
    }

    /// The corners that there are legs to, in order.
    pub fn at_corners(&self) -> &[AtCorner] {
        &self.at
    }

    /// Numbers of legs by corner and reflections, in order.
    pub fn counts(&self) -> &[LegCount] {
        &self.counts
    }

    /// Returns the legs to one corner.
    pub fn to(&self, corner: u32) -> &[Leg] {
        match self.at.binary_search_by_key(&corner, |at| at.corner) {
            Ok(at) => {
                let Range { start, end } = self.at[at].legs;
                &self.legs[start as usize..end as usize]
            }
            Err(_) => &[],
        }
    }

    /// Directions in which the legs leave their point, which is at `from` \[rad\].
    pub fn azimuths_rad(&self, corners: &Corners, from: DVec2) -> Vec<f64> {
        let azimuth = |leg: &Leg| {
            let corner = corners.wedges[leg.corner as usize].point;
            let first = self.reflections_of(leg).first();
            path::azimuth(first.map_or(corner, |reflection| reflection.point) - from)
        };
        self.legs.iter().map(azimuth).collect()
    }

    /// The reflections of a leg, in order from the point to the corner.
    pub fn reflections_of(&self, leg: &Leg) -> &[Interaction] {
        let first = leg.first_reflection as usize;
        &self.reflections[first..first + leg.reflections as usize]
    }
}
