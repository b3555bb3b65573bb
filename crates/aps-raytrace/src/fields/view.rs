//! What a source sees, piece by piece: the part of the street between two rays, up to one wall.
//!
//! [`crate::beam`] finds which walls a source sees, each with a window around what is seen of it. Their upper envelope in
//! inverse depth, taken once more over these few, gives the exact pieces: every ray of a piece meets the same wall first.

use glam::DVec2;

use super::canvas::HalfPlane;
use crate::beam::{Beam, Sweep, Window, visible_walls};
use crate::scene::{Scene, Wall};

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
    /// Where the two rays meet it: 0 at its start, 1 at its end.
    at: [f64; 2],
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
            seen,
            events,
            active,
        } = scratch;
        windows.clear();
        visible_walls(scene, &self.beam, sweep, windows, |_, _| {});
        seen.clear();
        events.clear();
        active.clear();
        events.extend([(self.lo, u32::MAX, true), (self.hi, u32::MAX, true)]);
        for window in windows {
            if let Some(wall) = Seen::new(self, &scene.walls()[window.wall as usize], window) {
                let n = seen.len() as u32;
                events.extend([(wall.from, n, false), (wall.to, n, true)]);
                seen.push(wall);
            }
        }
        events.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        let (middle, half) = (reach[0].midpoint(reach[1]), (reach[1] - reach[0]) * 0.5);
        let beyond = self.project(middle).y + half.dot(self.forward.abs());

        // One stretch of k after another; neighbouring ones that end at the same wall are one.
        let mut current: Option<(f64, f64, Option<u32>)> = None;
        let mut flush = |stretch: Option<(f64, f64, Option<u32>)>| {
            out.extend(stretch.and_then(|(k0, k1, n)| self.piece(k0, k1, n, seen, beyond)));
        };
        for (i, &(k, n, ends)) in events.iter().enumerate() {
            if n != u32::MAX {
                match active.iter().position(|&m| m == n) {
                    Some(at) if ends => drop(active.swap_remove(at)),
                    _ => active.push(n),
                }
            }
            let Some(&(next, ..)) = events.get(i + 1) else {
                break;
            };
            let (from, to) = (k.max(self.lo), next.min(self.hi));
            if from >= to {
                continue;
            }
            let middle = from + (to - from) * 0.5;
            let depth = |n: &u32| seen[*n as usize].inverse_depth(middle);
            let nearest = active.iter().copied();
            let nearest = nearest.reduce(|p, q| if depth(&q) > depth(&p) { q } else { p });
            current = match current {
                Some((k0, _, wall)) if wall == nearest => Some((k0, to, wall)),
                before => {
                    flush(before);
                    Some((from, to, nearest))
                }
            };
        }
        flush(current);
    }

    fn piece(&self, k0: f64, k1: f64, n: Option<u32>, seen: &[Seen], beyond: f64) -> Option<Piece> {
        let near = [k0, k1].map(|k| self.point(k, self.near));
        let Some(n) = n else {
            return (beyond > self.near).then(|| Piece {
                apex: self.apex,
                near,
                far: [k0, k1].map(|k| self.point(k, beyond)),
                wall: None,
                at: [0.0; 2],
            });
        };
        let seen = &seen[n as usize];
        let at = [k0, k1].map(|k| seen.at(k));
        Some(Piece {
            apex: self.apex,
            near,
            far: at.map(|at| seen.wall.a + seen.wall.along() * at),
            wall: Some(seen.id),
            at,
        })
    }
}

/// The part of a wall that may be seen.
#[derive(Debug, Clone, Copy)]
struct Seen {
    id: u32,
    wall: Wall,
    /// Ends of the wall across and forward.
    a: DVec2,
    b: DVec2,
    /// Range of k.
    from: f64,
    to: f64,
}

impl Seen {
    fn new(view: &View, wall: &Wall, window: &Window) -> Option<Self> {
        let (a, b) = (view.project(wall.a), view.project(wall.b));
        // Windows are a little wider than what is seen; walls are not.
        let k = |at: f64| {
            let p = a + (b - a) * at.clamp(0.0, 1.0);
            p.x / p.y
        };
        let (p, q) = (k(window.lo), k(window.hi));
        let seen = Self {
            id: window.wall,
            wall: *wall,
            a,
            b,
            from: p.min(q),
            to: p.max(q),
        };
        (seen.from < seen.to && seen.from.is_finite() && seen.to.is_finite()).then_some(seen)
    }

    fn inverse_depth(&self, k: f64) -> f64 {
        let d = self.b - self.a;
        (d.y * k - d.x) / self.a.perp_dot(self.b)
    }

    /// Where ray k meets the wall.
    fn at(&self, k: f64) -> f64 {
        let d = self.b - self.a;
        ((k * self.a.y - self.a.x) / (d.x - k * d.y)).clamp(0.0, 1.0)
    }
}

/// Reusable memory of [`View::pieces`].
#[derive(Debug, Default)]
pub(super) struct Scratch {
    sweep: Sweep,
    windows: Vec<Window>,
    seen: Vec<Seen>,
    events: Vec<(f64, u32, bool)>,
    active: Vec<u32>,
}
