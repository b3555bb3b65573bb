//! Pieces of a view: the parts of the street that a source sees, each between two rays and up to one wall.
//!
//! [`crate::beam`] tells from which ray on which wall is the nearest: every ray of a piece meets the same wall first.

use glam::DVec2;

use super::canvas::HalfPlane;
use crate::beam::{Beam, Sweep, Window, visible_walls};
use crate::scene::{Scene, Wall};

/// Rays nearer to each other than this, in k / (1 + |k|), are one: far above rounding, far below what pixels tell apart.
const ONE_RAY: f64 = 1e-12;

/// The part of a view between two neighbouring rays, up to the wall that both meet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// The source, or its image.
    apex: DVec2,
    /// Ends of the right and the left ray on the near side: the source, or the window it looks through \[m\].
    near: [DVec2; 2],
    /// Their ends at the wall, or beyond the reach \[m\].
    pub far: [DVec2; 2],
    /// The wall they meet.
    pub wall: Option<u32>,
    /// Places on the wall at which the two rays meet it: 0 at its start, 1 at its end.
    pub at: [f64; 2],
}

impl Piece {
    /// Lowest and highest y of the piece \[m\].
    pub fn heights_m(&self) -> [f64; 2] {
        let ends = self.near.iter().chain(&self.far).map(|p| p.y);
        let low = ends.clone().fold(f64::INFINITY, f64::min);
        [low, ends.fold(f64::NEG_INFINITY, f64::max)]
    }

    /// The half-planes that the piece is the common part of, given the wall that the source is an image behind. Its corners
    /// may be as near to each other as rounding is: they do not tell where its sides point.
    pub fn sides(&self, scene: &Scene, mirror: Option<u32>) -> impl Iterator<Item = HalfPlane> {
        let [right, left] = self.far.map(|end| end - self.apex);
        let rays = [right, -left].map(|direction| HalfPlane {
            point: self.apex,
            direction,
        });
        let walls = [self.wall, mirror].into_iter().flatten();
        let walls = walls.map(|id| HalfPlane::before(&scene.walls()[id as usize]));
        rays.into_iter().chain(walls)
    }
}

/// All directions from an apex with lo <= k <= hi, beyond depth `near`: k is the coordinate across over that forward.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    beam: Beam,
    apex: DVec2,
    across: DVec2,
    forward: DVec2,
    lo: f64,
    hi: f64,
    near: f64,
}

impl View {
    /// The four quadrants around a point.
    pub fn around(apex: DVec2) -> [Self; 4] {
        // In the order of the beams.
        let forward = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
        let beams = Beam::quadrants(apex);
        std::array::from_fn(|i| Self {
            beam: beams[i],
            apex,
            across: forward[i].perp(),
            forward: forward[i],
            lo: -1.0,
            hi: 1.0,
            near: 0.0,
        })
    }

    /// The view from the image of `source` behind the wall that a piece of its view ends at, through that piece; with the
    /// image. `None` without a wall, or where the source is on its line.
    pub fn reflected(scene: &Scene, source: DVec2, piece: &Piece) -> Option<(Self, DVec2)> {
        let id = piece.wall?;
        let wall = &scene.walls()[id as usize];
        let apex = wall.mirror(source);
        // From right to left is from a wall's end to its start.
        let [hi, lo] = piece.at;
        let window = Window { wall: id, lo, hi };
        let beam = Beam::through(apex, wall, window)?;
        let (along, outward) = wall.frame(apex);
        let near = -outward;
        let k = |at: f64| (at * wall.along().length_squared() - along) / near;
        let view = Self {
            beam,
            apex,
            across: wall.along(),
            forward: wall.outward(),
            lo: k(lo),
            hi: k(hi),
            near,
        };
        (view.lo < view.hi && view.lo.is_finite() && view.hi.is_finite()).then_some((view, apex))
    }

    fn project(&self, p: DVec2) -> DVec2 {
        let r = p - self.apex;
        DVec2::new(r.dot(self.across), r.dot(self.forward))
    }

    /// The point on ray k at a depth.
    fn point(&self, k: f64, depth: f64) -> DVec2 {
        let scale = depth / self.forward.length_squared();
        self.apex + (self.across * k + self.forward) * scale
    }

    /// Appends the pieces of the view, from right to left. Where no wall is met they end at the farthest depth of the box
    /// between `reach`, and are left out when all of it lies before the window.
    pub fn pieces(
        &self,
        scene: &Scene,
        reach: [DVec2; 2],
        scratch: &mut Scratch,
        out: &mut Vec<Piece>,
    ) {
        let Scratch {
            sweep,
            windows,
            nearest,
        } = scratch;
        windows.clear();
        nearest.clear();
        visible_walls(scene, &self.beam, sweep, windows, |k, wall| {
            nearest.push((k, wall));
        });
        // A wall is nearest until another is, at most up to its own end.
        nearest.dedup_by_key(|from| from.1);
        let (middle, half) = (reach[0].midpoint(reach[1]), (reach[1] - reach[0]) * 0.5);
        let beyond = self.project(middle).y + half.dot(self.forward.abs());
        let mut open_from = self.lo;
        for (i, &(k, id)) in nearest.iter().enumerate() {
            out.extend(self.open(open_from, k, beyond));
            let next = nearest.get(i + 1).map_or(self.hi, |next| next.0);
            open_from = next.min(self.end_of(&scene.walls()[id as usize]));
            out.extend(self.up_to(k, open_from, id, &scene.walls()[id as usize]));
        }
        out.extend(self.open(open_from, self.hi, beyond));
    }

    /// The ray on which a wall ends to the left, or the last one where it goes on behind the window.
    fn end_of(&self, wall: &Wall) -> f64 {
        // A wall with its front to the apex starts on the left.
        let start = self.project(wall.a);
        match start.y > self.near {
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

    /// The piece between two rays that meet no wall.
    fn open(&self, from: f64, to: f64, beyond: f64) -> Option<Piece> {
        let rays = self.stretch(from, to)?;
        (beyond > self.near).then(|| Piece {
            apex: self.apex,
            near: rays.map(|k| self.point(k, self.near)),
            far: rays.map(|k| self.point(k, beyond)),
            wall: None,
            at: [0.0; 2],
        })
    }

    /// The piece between two rays that meet a wall.
    fn up_to(&self, from: f64, to: f64, id: u32, wall: &Wall) -> Option<Piece> {
        let rays = self.stretch(from, to)?;
        let (a, b) = (self.project(wall.a), self.project(wall.b));
        let d = b - a;
        let at = rays.map(|k| ((k * a.y - a.x) / (d.x - k * d.y)).clamp(0.0, 1.0));
        Some(Piece {
            apex: self.apex,
            near: rays.map(|k| self.point(k, self.near)),
            far: at.map(|at| wall.a + wall.along() * at),
            wall: Some(id),
            at,
        })
    }
}

/// Reusable memory of [`View::pieces`].
#[derive(Debug, Default)]
pub(super) struct Scratch {
    sweep: Sweep,
    windows: Vec<Window>,
    nearest: Vec<(f64, u32)>,
}
