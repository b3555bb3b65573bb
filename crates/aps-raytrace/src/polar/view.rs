//! Pieces of a view: the parts of the street that a source sees, each between two rays and up to one wall.
//!
//! [`crate::beam`] tells from which ray on which wall is the nearest: every ray of a piece meets the same wall first.

use glam::DVec2;

use crate::beam::{Beam, Sweep, Window, visible_walls};
use crate::scene::{Scene, Wall};

/// Distance in k / (1 + |k|) below which two rays are one: far above rounding.
const ONE_RAY: f64 = 1e-12;

/// Distance from the end of a wall, in parts of its length, below which a ray meets the end.
const AT_END: f64 = 1e-9;

/// The part of a view between two neighbouring rays, up to the wall that both meet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// The wall they meet.
    pub wall: u32,
    /// Places on the wall at which the right and the left ray meet it: 0 at its start, 1 at its end.
    pub at: [f64; 2],
}

impl Piece {
    /// Ends of the wall that are ends of the piece: 0 for its start, 1 for its end.
    pub fn ends(&self) -> impl Iterator<Item = usize> {
        let is_end = |&end: &usize| {
            let to_end = |at: f64| (at - end as f64).abs() <= AT_END;
            self.at.into_iter().any(to_end)
        };
        [0, 1].into_iter().filter(is_end)
    }
}

/// The directions of a beam with lo <= k <= hi.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    beam: Beam,
    lo: f64,
    hi: f64,
}

impl View {
    /// The four quadrants around a point.
    pub fn around(apex: DVec2) -> [Self; 4] {
        Beam::quadrants(apex).map(|beam| Self {
            beam,
            lo: -1.0,
            hi: 1.0,
        })
    }

    /// The view from the image of `source` behind the wall that a piece of its view ends at, through that piece; with the
    /// image. `None` where the source is on its line.
    pub fn reflected(scene: &Scene, source: DVec2, piece: &Piece) -> Option<(Self, DVec2)> {
        let id = piece.wall;
        let wall = &scene.walls()[id as usize];
        let apex = wall.mirror(source);
        // From right to left is from a wall's end to its start.
        let [hi, lo] = piece.at;
        let window = Window { wall: id, lo, hi };
        let beam = Beam::through(apex, wall, window)?;
        let (lo, hi) = (beam.lo, beam.hi);
        let view = Self { beam, lo, hi };
        (lo < hi && lo.is_finite() && hi.is_finite()).then_some((view, apex))
    }

    /// Appends the pieces of the view that end at walls, from right to left.
    pub fn pieces(&self, scene: &Scene, scratch: &mut Scratch, out: &mut Vec<Piece>) {
        let (windows, nearest) = (&mut scratch.windows, &mut scratch.nearest);
        windows.clear();
        nearest.clear();
        let nearest_from = |k, wall| nearest.push((k, wall));
        visible_walls(scene, &self.beam, &mut scratch.sweep, windows, nearest_from);
        // A wall is nearest until another is, at most up to its own end.
        nearest.dedup_by_key(|from| from.1);
        for (i, &(k, id)) in nearest.iter().enumerate() {
            let next = nearest.get(i + 1).map_or(self.hi, |next| next.0);
            let wall = &scene.walls()[id as usize];
            out.extend(self.up_to(k, next.min(self.end_of(wall)), id, wall));
        }
    }

    /// The ray on which a wall ends to the left, or the last one where it goes on behind the window.
    fn end_of(&self, wall: &Wall) -> f64 {
        // A wall with its front to the apex starts on the left.
        let start = self.beam.project(wall.a);
        match start.y > self.beam.near {
            true => start.x / start.y,
            false => self.hi,
        }
    }

    /// Narrows a stretch of rays to the view. `None` for hardly more than one ray: rounding tells the ends of two walls at one
    /// corner apart, and between them lies what is behind.
    fn stretch(&self, from: f64, to: f64) -> Option<[f64; 2]> {
        let (from, to) = (from.max(self.lo), to.min(self.hi));
        (to - from > ONE_RAY * (1.0 + from.abs())).then_some([from, to])
    }

    /// The piece between two rays that meet a wall.
    fn up_to(&self, from: f64, to: f64, id: u32, wall: &Wall) -> Option<Piece> {
        let rays = self.stretch(from, to)?;
        let (a, b) = (self.beam.project(wall.a), self.beam.project(wall.b));
        let d = b - a;
        let at = rays.map(|k| ((k * a.y - a.x) / (d.x - k * d.y)).clamp(0.0, 1.0));
        Some(Piece { wall: id, at })
    }
}

/// Reusable memory of [`View::pieces`].
#[derive(Debug, Default)]
pub(super) struct Scratch {
    sweep: Sweep,
    windows: Vec<Window>,
    nearest: Vec<(f64, u32)>,
}
