//! Legs: everything between one point and the corners it reaches without diffraction.

use std::ops::Range;

use glam::DVec2;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::chain::{self, Chain};
use crate::images::{ImageTree, Sight, TreeScratch, sights};
use crate::material::Reflector;
use crate::path::Interaction;
use crate::scene::Scene;
use crate::wedge::{Ray, Wedge};

/// Corners of a scene that diffract, and the walls that each sees: prepared once a map.
#[derive(Debug, Clone, Default)]
pub(crate) struct Corners {
    pub wedges: Vec<Wedge>,
    pub sights: Vec<Vec<Sight>>,
}

impl Corners {
    /// Finds the corners; `with_sights`: the walls they see too, which only reflections need.
    pub fn new(
        scene: &Scene,
        reflectors: &[Reflector],
        wavenumber_per_m: f64,
        with_sights: bool,
    ) -> Self {
        let wedges = scene.wedges(reflectors, wavenumber_per_m);
        let sights = wedges
            .par_iter()
            .map_init(TreeScratch::default, |scratch, wedge| {
                if !with_sights {
                    return Vec::new();
                }
                // Its own building hides what lies behind it.
                sights(scene, wedge.point, scratch, |window| {
                    let wall = &scene.walls()[window.wall as usize];
                    [window.lo, window.hi]
                        .iter()
                        .all(|&s| wedge.is_inside(wall.a + wall.along() * s - wedge.point))
                })
            })
            .collect();
        Self { wedges, sights }
    }
}

/// One way from a point to a corner, by reflections or straight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leg {
    /// Index into [`Corners::wedges`].
    pub corner: u32,
    /// At the corner, back towards the point.
    pub ray: Ray,
    /// The corner as seen from the point \[m\].
    pub corner_image: DVec2,
    /// Product of the reflection coefficients.
    pub coefficient: Complex64,
    /// Its magnitude over the square root of the length: for bounds.
    pub strength: f64,
    first_reflection: u32,
    pub reflections: u32,
}

/// Nearer to each other than this \[m\] two points are one: squares of distances, and powers over
/// them, must stay numbers.
pub(crate) const NEAREST_M: f64 = 1e-100;

/// Legs of one point, sorted by corner, then by reflections.
#[derive(Debug, Clone, Default)]
pub(crate) struct Legs {
    legs: Vec<Leg>,
    reflections: Vec<Interaction>,
    /// First leg of each corner, and the end.
    first: Vec<u32>,
}

impl Legs {
    /// Finds them: `tree` holds the images of `from`. `None` if they take more than `max_bytes`.
    pub fn find(
        scene: &Scene,
        reflectors: &[Reflector],
        corners: &Corners,
        from: DVec2,
        tree: &ImageTree,
        max_reflections: usize,
        max_bytes: usize,
    ) -> Option<Self> {
        let mut found = Self::default();
        for (c, wedge) in corners.wedges.iter().enumerate() {
            found.first.push(found.legs.len() as u32);
            let to = wedge.point;
            if from.distance(to) >= NEAREST_M && !scene.is_blocked(from, to, [None; 2]) {
                found.push(c, wedge, from, Chain::direct(from, to));
            }
            tree.for_each_candidate(&corners.sights[c], max_reflections, |image| {
                let chain = chain::resolve(scene, reflectors, tree, image, from, to);
                if let Some(chain) = chain
                    && found.bytes() <= max_bytes
                {
                    found.push(c, wedge, tree.images[image as usize].point, chain);
                }
            });
            if found.bytes() > max_bytes {
                return None;
            }
        }
        found.first.push(found.legs.len() as u32);
        Some(found)
    }

    /// Memory they take.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.legs) + size_of_val(&*self.reflections)
    }

    fn push(&mut self, corner: usize, wedge: &Wedge, seen_at: DVec2, chain: Chain) {
        // Through the gap between two buildings that touch at the corner.
        if wedge.is_inside(seen_at - wedge.point) {
            return;
        }
        let ray = wedge.ray(seen_at);
        self.legs.push(Leg {
            corner: corner as u32,
            ray,
            corner_image: chain.far_image,
            coefficient: chain.coefficient,
            strength: chain.coefficient.norm() / ray.length_m.sqrt(),
            first_reflection: self.reflections.len() as u32,
            reflections: chain.reflections.len() as u32,
        });
        self.reflections.extend_from_slice(&chain.reflections);
    }

    /// The legs to all corners.
    pub fn all(&self) -> &[Leg] {
        &self.legs
    }

    /// Places of the legs to one corner.
    #[inline]
    pub fn range_to(&self, corner: u32) -> Range<usize> {
        match self.first.get(corner as usize..corner as usize + 2) {
            Some(&[from, to]) => from as usize..to as usize,
            _ => 0..0,
        }
    }

    /// Legs to one corner.
    #[inline]
    pub fn to(&self, corner: u32) -> &[Leg] {
        &self.legs[self.range_to(corner)]
    }

    /// The reflections of a leg, in order from the point to the corner.
    pub fn reflections_of(&self, leg: &Leg) -> &[Interaction] {
        let first = leg.first_reflection as usize;
        &self.reflections[first..first + leg.reflections as usize]
    }
}
