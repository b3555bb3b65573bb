//! Paths with at most one reflection and at most one diffraction by exhaustion: every corner,
//! every wall before or after it, with gains by the textbook.

use std::f64::consts::{PI, TAU};

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Wall;
use aps_raytrace::{Complex64, InteractionKind};

use crate::brute_force::{Candidate, examine};
use crate::links::Sequence;
use crate::utd::Radio;

/// A sequence of interactions, with the path that they give.
#[derive(Debug, Clone)]
pub struct MixedCandidate {
    /// From the transmitter.
    pub sequence: Sequence,
    /// Sum of the legs \[m\].
    pub length_m: f64,
    /// Distance to the nearest change of mind \[m\]; negative when the sequence is no path.
    pub clearance_m: f64,
    /// Angle of the rays at the corner from the nearest shadow or reflection boundary \[rad\]:
    /// nearer than rounding, the textbook's formula is not defined. Infinite without a corner.
    pub off_boundary_rad: f64,
    /// Gain.
    pub gain: Complex64,
}

/// Finds all candidates whose clearance is above `-tolerance_m`.
#[must_use]
pub fn mixed_candidates(
    walls: &[Wall],
    radio: Radio,
    tx: DVec2,
    rx: DVec2,
    tolerance_m: f64,
) -> Vec<MixedCandidate> {
    let one_wall = |from: DVec2, to: DVec2, faces: &[u32]| -> Vec<Candidate> {
        let ids = (0..walls.len() as u32).filter(|id| !faces.contains(id));
        ids.filter_map(|id| examine(walls, from, to, &[id], faces, tolerance_m))
            .collect()
    };
    let straight =
        |from: DVec2, to: DVec2, faces: &[u32]| examine(walls, from, to, &[], faces, tolerance_m);
    let mut found: Vec<MixedCandidate> = straight(tx, rx, &[])
        .into_iter()
        .chain(one_wall(tx, rx, &[]))
        .map(|c| reflected(walls, radio, c))
        .collect();
    for id in 0..walls.len() as u32 {
        let Some(corner) = Corner::new(walls, id) else {
            continue;
        };
        let faces = [id, walls[id as usize].previous];
        let (before, after) = (
            straight(tx, corner.point, &faces),
            straight(rx, corner.point, &faces),
        );
        let mut join = |p: &Candidate, q: &Candidate| {
            found.push(corner.diffracted(walls, radio, p, q));
        };
        if let (Some(p), Some(q)) = (&before, &after) {
            join(p, q);
        }
        if let Some(q) = &after {
            for p in one_wall(tx, corner.point, &faces) {
                join(&p, q);
            }
        }
        if let Some(p) = &before {
            for q in one_wall(rx, corner.point, &faces) {
                join(p, &q);
            }
        }
    }
    found.retain(|c| c.clearance_m > -tolerance_m);
    found
}

/// Reflection coefficients along a candidate, by the angle between leg and normal.
fn reflections(walls: &[Wall], radio: Radio, c: &Candidate) -> Complex64 {
    c.walls
        .iter()
        .zip(c.points.windows(2))
        .map(|(&id, leg)| {
            let wall = &walls[id as usize];
            radio.reflection(PI / 2.0 - between(leg[1] - leg[0], wall.b - wall.a))
        })
        .product()
}

/// Angle between two lines, 0..=pi/2.
fn between(d: DVec2, e: DVec2) -> f64 {
    d.perp_dot(e).abs().atan2(d.dot(e).abs())
}

fn reflections_of(c: &Candidate) -> Sequence {
    let kind = InteractionKind::Reflection;
    c.walls.iter().map(|&id| (kind, id)).collect()
}

fn reflected(walls: &[Wall], radio: Radio, c: Candidate) -> MixedCandidate {
    let coefficient = reflections(walls, radio, &c);
    MixedCandidate {
        sequence: reflections_of(&c),
        length_m: c.length_m,
        clearance_m: c.clearance_m,
        off_boundary_rad: f64::INFINITY,
        gain: radio.spherical_wave(c.length_m) / c.length_m * coefficient,
    }
}

/// A convex corner.
struct Corner {
    id: u32,
    point: DVec2,
    /// Direction of the 0-face, the wall that starts here \[rad\].
    face_0: f64,
    n: f64,
}

impl Corner {
    fn new(walls: &[Wall], id: u32) -> Option<Self> {
        let wall = &walls[id as usize];
        let before = &walls[wall.previous as usize];
        let face_0 = (wall.b - wall.a).to_angle();
        let face_n = (before.a - before.b).to_angle();
        // The building lies counter-clockwise of the 0-face.
        let interior = (face_n - face_0).rem_euclid(TAU);
        (interior < PI).then_some(Self {
            id,
            point: wall.a,
            face_0,
            n: (TAU - interior) / PI,
        })
    }

    /// Angle of the last leg, seen from the corner, from the 0-face through the street; and how
    /// far the leg is from running into a face \[m\].
    fn ray(&self, c: &Candidate) -> (f64, f64) {
        let leg = c.points[c.points.len() - 2] - self.point;
        let phi = (self.face_0 - leg.to_angle()).rem_euclid(TAU);
        // Beyond half of the inside the 0-face is the nearer one.
        let from_n = self.n * PI - phi;
        let from_0 = if from_n < -(2.0 - self.n) * PI / 2.0 {
            phi - TAU
        } else {
            phi
        };
        (phi, from_0.min(from_n) * leg.length())
    }

    /// The path along `before`, from the transmitter to the corner, and `after`, from the
    /// receiver to the corner.
    fn diffracted(
        &self,
        walls: &[Wall],
        radio: Radio,
        before: &Candidate,
        after: &Candidate,
    ) -> MixedCandidate {
        let mut sequence = reflections_of(before);
        sequence.push((InteractionKind::Diffraction, self.id));
        sequence.extend(reflections_of(after).into_iter().rev());
        let ((p, off_p), (q, off_q)) = (self.ray(before), self.ray(after));
        let (s1, s2) = (before.length_m, after.length_m);
        let off_boundary_rad = [
            (p - q).abs() - PI,
            p + q - PI,
            p + q - (2.0 * self.n - 1.0) * PI,
        ]
        .into_iter()
        .fold(f64::INFINITY, |least, d| least.min(d.abs()));
        // The field at the corner, and what the wedge makes of it.
        let incident = radio.spherical_wave(s1 + s2) / s1;
        let spread = (s1 / (s2 * (s1 + s2))).sqrt();
        let d = radio.diffraction(self.n, s1 * s2 / (s1 + s2), [p, q]);
        let gammas = reflections(walls, radio, before) * reflections(walls, radio, after);
        MixedCandidate {
            sequence,
            length_m: s1 + s2,
            clearance_m: [before.clearance_m, after.clearance_m, off_p, off_q]
                .into_iter()
                .fold(f64::INFINITY, f64::min),
            off_boundary_rad,
            gain: incident * d * spread * gammas,
        }
    }
}
