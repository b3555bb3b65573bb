//! Finds the walls that a source sees through a window, and the visible part of each.
//!
//! Seen from a fixed apex, the inverse depth of a straight wall is a linear function of the
//! projective coordinate k = x / z across the view. The visible parts of all walls are therefore
//! the upper envelope of linear functions, each on an interval; walls do not cross, so between
//! two neighbouring interval ends one of them is on top throughout.
//!
//! Windows come out slightly too wide ([`WINDOW_MARGIN`]), never too narrow: they only select
//! candidates, which are decided exactly later.

use glam::DVec2;
use multiversion::multiversion;

use crate::scene::{Scene, Wall};
use crate::wall_index::{HalfPlane, Selected};

/// Windows grow by this part of their wall's length at both ends: far above the rounding of the
/// sweep, far below anything that would bring in many more candidates.
const WINDOW_MARGIN: f64 = 1e-7;

/// Wall ends nearer to each other than this, in k / (1 + |k|), may lie on one ray: far above the
/// rounding of k.
const SAME_RAY: f64 = 1e-9;

/// A part of a wall: from `lo` to `hi`, 0 at the wall's start and 1 at its end, widened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Window {
    pub wall: u32,
    pub lo: f64,
    pub hi: f64,
}

/// A view from a point: all directions with lo <= k <= hi, beyond depth `near`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beam {
    apex: DVec2,
    /// Axis of x across the view.
    across: DVec2,
    /// Axis of z into the view.
    forward: DVec2,
    pub lo: f64,
    pub hi: f64,
    pub near: f64,
}

impl Beam {
    /// The four quadrants around a point, overlapping a little: no ray is only on an edge.
    pub fn quadrants(apex: DVec2) -> [Self; 4] {
        [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y].map(|forward| Self {
            apex,
            across: forward.perp(),
            forward,
            lo: -1.0 - WINDOW_MARGIN,
            hi: 1.0 + WINDOW_MARGIN,
            near: 0.0,
        })
    }

    /// The view from an image behind `wall` through a window in it; `None` when the image lies
    /// on the wall's line or before it.
    pub fn through(image: DVec2, wall: &Wall, window: Window) -> Option<Self> {
        let (along, outward) = wall.frame(image);
        let near = -outward;
        let length_squared = wall.along().length_squared();
        (near > 0.0).then(|| Self {
            apex: image,
            across: wall.along(),
            forward: wall.outward(),
            lo: (window.lo * length_squared - along) / near,
            hi: (window.hi * length_squared - along) / near,
            near,
        })
    }

    /// Coordinates (x, z) of a point.
    #[inline]
    pub fn project(&self, p: DVec2) -> DVec2 {
        let r = p - self.apex;
        DVec2::new(r.dot(self.across), r.dot(self.forward))
    }

    /// A region that holds all of the view.
    #[inline]
    fn region(&self) -> [HalfPlane; 3] {
        [
            (self.forward, self.near),
            (self.forward * self.hi - self.across, 0.0),
            (self.across - self.forward * self.lo, 0.0),
        ]
        .map(|(axis, limit)| HalfPlane {
            axis,
            limit: limit + axis.dot(self.apex),
        })
    }
}

/// A wall's part inside the view.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    wall: u32,
    /// Ends in (x, z), not clipped.
    a: DVec2,
    b: DVec2,
    /// Coefficients of 1 / z = slope k + offset.
    slope: f64,
    offset: f64,
    /// Visible range of k found so far.
    seen_lo: f64,
    seen_hi: f64,
}

/// Reusable memory of [`visible_walls`].
#[derive(Debug, Clone, Default)]
pub(crate) struct Sweep {
    selected: Selected,
    candidates: Vec<Candidate>,
    /// Interval ends: k, the candidate, and true where it ends there.
    events: Vec<(f64, u32, bool)>,
    active: Vec<u32>,
}

/// Appends the window of every wall of which the beam sees some part.
///
/// `nearest_from` is told, in order, which wall is the nearest from which k on.
///
/// A window is the hull of the parts seen. Walls facing away from the apex are neither seen nor
/// obstruct: a ray that leaves from outdoors meets the front of a building first.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512dq", "x86_64+avx2"))]
pub(crate) fn visible_walls<F: FnMut(f64, u32)>(
    scene: &Scene,
    beam: &Beam,
    sweep: &mut Sweep,
    out: &mut Vec<Window>,
    mut nearest_from: F,
) {
    sweep.candidates.clear();
    sweep.events.clear();
    sweep.active.clear();
    scene.index().select(&beam.region(), &mut sweep.selected);
    for &id in &sweep.selected {
        if let Some((candidate, from, to)) = clip(&scene.walls()[id as usize], id, beam) {
            let n = sweep.candidates.len() as u32;
            sweep.events.push((from, n, false));
            sweep.events.push((to, n, true));
            sweep.candidates.push(candidate);
        }
    }
    sweep.events.sort_unstable_by(|p, q| p.0.total_cmp(&q.0));

    let (candidates, active) = (&mut sweep.candidates, &mut sweep.active);
    let events = &sweep.events;
    let mut group_end = 0;
    for (i, &(k, n, ends)) in events.iter().enumerate() {
        if i >= group_end {
            let slack = SAME_RAY * (1.0 + k.abs());
            group_end = i + 1;
            while events.get(group_end).is_some_and(|e| e.0 <= k + slack) {
                group_end += 1;
            }
            // At the edges of the view walls are cut, not at their ends.
            if beam.lo + slack < k && k + slack < beam.hi {
                glimpse(candidates, active, &events[i..group_end]);
            }
        }
        if ends {
            if let Some(at) = active.iter().position(|&m| m == n) {
                active.swap_remove(at);
            }
        } else {
            active.push(n);
        }
        let Some(&(next, ..)) = events.get(i + 1) else {
            break;
        };
        if next <= k {
            continue;
        }
        let middle = k + (next - k) * 0.5;
        let mut nearest: Option<(u32, f64)> = None;
        for &n in active.iter() {
            let inverse = candidates[n as usize].inverse_depth(middle);
            if nearest.is_none_or(|(_, best)| inverse > best) {
                nearest = Some((n, inverse));
            }
        }
        if let Some((n, _)) = nearest {
            let c = &mut candidates[n as usize];
            c.seen_lo = c.seen_lo.min(k);
            c.seen_hi = c.seen_hi.max(next);
            nearest_from(k, c.wall);
        }
    }
    out.extend(candidates.iter().filter_map(Candidate::window));
}

/// Marks walls that begin or end on one ray and are seen along this ray, if nowhere else: a ray
/// that touches a corner goes on, to another corner perhaps, though the first hides all beside
/// it. Only walls that neither begin nor end here hide what is behind them.
#[inline(always)]
fn glimpse(candidates: &mut [Candidate], active: &[u32], group: &[(f64, u32, bool)]) {
    let &[(k, ..), _, ..] = group else {
        return;
    };
    let hides = |n: &u32| !group.iter().any(|e| e.1 == *n);
    let nearest = active
        .iter()
        .copied()
        .filter(hides)
        .map(|n| candidates[n as usize].inverse_depth(k))
        .fold(f64::NEG_INFINITY, f64::max);
    for &(k, n, _) in group {
        let c = &mut candidates[n as usize];
        if c.inverse_depth(k) >= nearest {
            c.seen_lo = c.seen_lo.min(k);
            c.seen_hi = c.seen_hi.max(k);
        }
    }
}

/// Clips a wall to the view: the candidate and its range of k.
#[inline(always)]
fn clip(wall: &Wall, id: u32, beam: &Beam) -> Option<(Candidate, f64, f64)> {
    if wall.frame(beam.apex).1 <= 0.0 {
        return None;
    }
    let (a, b) = (beam.project(wall.a), beam.project(wall.b));
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    let bounds = [
        (a.y - beam.near, b.y - beam.near),
        (beam.hi * a.y - a.x, beam.hi * b.y - b.x),
        (a.x - beam.lo * a.y, b.x - beam.lo * b.y),
    ];
    for (at_a, at_b) in bounds {
        match (at_a >= 0.0, at_b >= 0.0) {
            (true, true) => {}
            (true, false) => to = to.min(at_a / (at_a - at_b)),
            (false, true) => from = from.max(at_a / (at_a - at_b)),
            (false, false) => return None,
        }
    }
    if from > to {
        return None;
    }
    let k = |t: f64| {
        let p = a + (b - a) * t;
        p.x / p.y
    };
    let (from, to) = (k(from), k(to));
    let (from, to) = (from.min(to), from.max(to));
    // A wall seen edge-on, or by a single ray, shows no part; NaN cannot pass either.
    if !(from < to && from.is_finite() && to.is_finite()) {
        return None;
    }
    let d = b - a;
    let cross = a.perp_dot(b);
    let candidate = Candidate {
        wall: id,
        a,
        b,
        slope: d.y / cross,
        offset: -d.x / cross,
        seen_lo: f64::INFINITY,
        seen_hi: f64::NEG_INFINITY,
    };
    Some((candidate, from, to))
}

impl Candidate {
    /// Inverse depth 1 / z where the ray k meets the wall.
    #[inline]
    fn inverse_depth(&self, k: f64) -> f64 {
        self.slope * k + self.offset
    }

    /// The part of the wall between the two rays that bound what was seen of it.
    fn window(&self) -> Option<Window> {
        if self.seen_lo > self.seen_hi {
            return None;
        }
        let d = self.b - self.a;
        let at = |k: f64| (k * self.a.y - self.a.x) / (d.x - k * d.y);
        let (p, q) = (at(self.seen_lo), at(self.seen_hi));
        Some(Window {
            wall: self.wall,
            lo: (p.min(q) - WINDOW_MARGIN).max(-WINDOW_MARGIN),
            hi: (p.max(q) + WINDOW_MARGIN).min(1.0 + WINDOW_MARGIN),
        })
    }
}
