//! Reflections by exhaustion: every sequence of walls, every leg against every wall, textbook
//! formulas, no index, no beams, no exact predicates.
//!
//! Floating point cannot decide whether a ray that passes within rounding of a corner gets by, so
//! each candidate comes with its clearance: how far, in metres, the closest decision is from
//! falling the other way. Positive means a path.

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Wall;

/// A sequence of walls, with the path that its images give.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Walls in order from the transmitter.
    pub walls: Vec<u32>,
    /// Transmitter, points of reflection, receiver \[m\].
    pub points: Vec<DVec2>,
    /// Sum of the legs \[m\].
    pub length_m: f64,
    /// Distance to the nearest change of mind \[m\]; negative when the sequence is no path.
    pub clearance_m: f64,
}

/// Finds all sequences of up to `max_order` walls whose clearance is above `-tolerance_m`.
#[must_use]
pub fn candidates(
    walls: &[Wall],
    tx: DVec2,
    rx: DVec2,
    max_order: usize,
    tolerance_m: f64,
) -> Vec<Candidate> {
    let mut found = Vec::new();
    let mut sequences = vec![Vec::new()];
    while let Some(sequence) = sequences.pop() {
        found.extend(examine(walls, tx, rx, &sequence, &[], tolerance_m));
        if sequence.len() < max_order {
            let others = (0..walls.len() as u32).filter(|id| sequence.last() != Some(id));
            sequences.extend(others.map(|id| [&sequence[..], &[id]].concat()));
        }
    }
    found
}

/// One sequence, unless its clearance is below `-tolerance_m`. When the receiver is a corner, the
/// walls in `corner` meet there and do not block the last leg.
pub(crate) fn examine(
    walls: &[Wall],
    tx: DVec2,
    rx: DVec2,
    sequence: &[u32],
    corner: &[u32],
    tolerance_m: f64,
) -> Option<Candidate> {
    // Images of the transmitter, then back from the receiver: the line to the last image meets
    // the last wall at the last reflection, and so on.
    let mut images = vec![tx];
    for &id in sequence {
        let wall = &walls[id as usize];
        let angle = 2.0 * (wall.b - wall.a).to_angle();
        let r = images[images.len() - 1] - wall.a;
        let (sin, cos) = angle.sin_cos();
        images.push(wall.a + DVec2::new(cos * r.x + sin * r.y, sin * r.x - cos * r.y));
    }
    let mut clearance_m = f64::INFINITY;
    let mut points = vec![rx];
    let mut at = rx;
    for (i, &id) in sequence.iter().enumerate().rev() {
        let wall = &walls[id as usize];
        let (t, s) = crossing(at, images[i + 1], wall.a, wall.b)?;
        let length = wall.a.distance(wall.b);
        clearance_m = clearance_m
            .min(t.min(1.0 - t) * at.distance(images[i + 1]))
            .min(s.min(1.0 - s) * length)
            .min(height(wall, at))
            .min(height(wall, images[i]));
        if clearance_m < -tolerance_m {
            return None;
        }
        at = wall.a + (wall.b - wall.a) * s;
        points.push(at);
    }
    points.push(tx);
    points.reverse();
    for (leg, ends) in points.windows(2).enumerate() {
        let (p, q) = (ends[0], ends[1]);
        for (id, wall) in walls.iter().enumerate() {
            let id = id as u32;
            let touches = (leg > 0 && sequence[leg - 1] == id)
                || (leg < sequence.len() && sequence[leg] == id);
            let ends_at_corner = leg == sequence.len() && corner.contains(&id);
            if touches || ends_at_corner {
                continue;
            }
            if let Some((t, s)) = crossing(p, q, wall.a, wall.b) {
                let on_leg = t.min(1.0 - t) * p.distance(q);
                let on_wall = s.min(1.0 - s) * wall.a.distance(wall.b);
                clearance_m = clearance_m.min(-on_leg.min(on_wall));
            }
        }
        if clearance_m < -tolerance_m {
            return None;
        }
    }
    Some(Candidate {
        walls: sequence.to_vec(),
        length_m: points.windows(2).map(|w| w[0].distance(w[1])).sum(),
        points,
        clearance_m,
    })
}

/// Distance of `p` in front of the wall's line \[m\].
fn height(wall: &Wall, p: DVec2) -> f64 {
    let d = (wall.b - wall.a).normalize();
    (p - wall.a).dot(DVec2::new(d.y, -d.x))
}

/// The crossing of the lines p-q and a-b, as parts of each; `None` when they are parallel.
fn crossing(p: DVec2, q: DVec2, a: DVec2, b: DVec2) -> Option<(f64, f64)> {
    let (d, e) = (q - p, b - a);
    let det = d.x * e.y - d.y * e.x;
    if det == 0.0 {
        return None;
    }
    let r = a - p;
    Some(((r.x * e.y - r.y * e.x) / det, (r.x * d.y - r.y * d.x) / det))
}
