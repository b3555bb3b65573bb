//! Diffraction at one convex corner of a scene: rays in its own angles, and the coefficient of
//! [`crate::utd`] between two of them.
//!
//! Angles count from the 0-face (the wall that starts at the corner) through the street to the
//! n-face (the wall that ends there): 0 to n pi, where n pi is the exterior angle. On which side
//! of a boundary a ray lies is decided by exact signs, as the paths themselves are: D jumps
//! just where a path appears or goes.

use std::f64::consts::{PI, TAU};

use glam::DVec2;
use num_complex::Complex64;

use crate::bound::{Direction, WedgeBound};
use crate::material::Reflector;
use crate::predicates::{orient, strictly_between};
use crate::ray::{ALONG_RAD, Ray};
use crate::scene::{Scene, Wall};
use crate::slope::{DiffractionMatrix, GammaSlopes};
use crate::utd::{self, Boundaries};

/// Angle from a boundary \[rad\] below which the side is taken from an exact sign.
const BOUNDARY_RAD: f64 = 1e-9;

/// A convex corner at one carrier.
#[derive(Debug, Clone)]
pub(crate) struct Wedge {
    /// Id of the corner: the wall that starts here.
    pub id: u32,
    pub point: DVec2,
    /// The far ends of both faces.
    ends: [DVec2; 2],
    /// Directions along and out of the 0-face, not normalised.
    face_0: (DVec2, DVec2),
    /// Directions along the n-face, away from the corner, and out of it, not normalised.
    face_n: (DVec2, DVec2),
    /// Exterior angle over pi, in (1, 2).
    n: f64,
    reflector_0: Reflector,
    reflector_n: Reflector,
    /// Slopes of the faces' reflection coefficients for rays along them \[1/rad\].
    grazing: [Complex64; 2],
    wavenumber_per_m: f64,
    /// -e^{-j pi/4} / (2 n sqrt(2 pi k)) \[sqrt(m)\].
    factor: Complex64,
    pub bound: WedgeBound,
}

impl Wedge {
    /// The wedge between two walls: the one that starts at the corner and the one that ends
    /// there, an open angle of more than pi apart.
    fn new(
        scene: &Scene,
        reflectors: &[Reflector],
        faces: [u32; 2],
        wavenumber_per_m: f64,
    ) -> Self {
        let [id, last] = faces;
        let next = &scene.walls()[id as usize];
        let previous = &scene.walls()[last as usize];
        let interior = next.along().angle_to(-previous.along());
        let n = (TAU - interior.abs()) / PI;
        let factor = utd::factor(n, wavenumber_per_m);
        Self {
            id,
            point: next.a,
            ends: [next.b, previous.a],
            face_0: (next.along(), next.outward()),
            face_n: (-previous.along(), previous.outward()),
            n,
            reflector_0: reflectors[id as usize],
            reflector_n: reflectors[last as usize],
            grazing: [id, last].map(|wall| reflectors[wall as usize].grazing_slope()),
            wavenumber_per_m,
            factor,
            bound: WedgeBound::new(n, wavenumber_per_m, factor),
        }
    }

    /// Returns true when the way to a place begins strictly between the faces, away from the street: in
    /// the building, or in the gap between two buildings that touch here.
    pub fn is_inside(&self, place: DVec2) -> bool {
        let [end_0, end_n] = self.ends;
        orient(self.point, end_0, place) > 0.0 && orient(end_n, self.point, place) > 0.0
    }

    /// The ray to a place: a terminal, another corner, or the image of one as seen from here.
    pub fn ray(&self, place: DVec2) -> Ray {
        let r = place - self.point;
        let angle = |(along, outward): (DVec2, DVec2)| {
            let angle = r.dot(outward).atan2(r.dot(along)).rem_euclid(TAU);
            // Rounding may turn a ray on the face, or one beyond the other face, into the wall;
            // inside the building the nearer face is meant.
            let beyond = angle - self.n * PI;
            if beyond > TAU - angle {
                0.0
            } else {
                angle - beyond.max(0.0)
            }
        };
        let (from_0, from_n) = (angle(self.face_0), angle(self.face_n));
        Ray {
            length_m: r.length(),
            from_0,
            from_n,
            place,
            gamma_0: self.reflector_0.reflection(from_0.sin().abs()),
            gamma_n: self.reflector_n.reflection(from_n.sin().abs()),
            slope: 0.0,
        }
    }

    /// The diffraction coefficient D \[sqrt(m)\] between two rays; symmetric in them.
    ///
    /// The distance parameter is s' s / (s' + s) of the two rays' lengths. Angles are taken from
    /// the face that one of the rays is nearest to, so that both faces are alike and a ray along
    /// a perfectly conducting one gives exactly 0.
    pub fn coefficient(&self, p: &Ray, q: &Ray) -> Complex64 {
        let n = self.n;
        let kl = self.wavenumber_per_m * utd::distance_m(p.length_m, q.length_m);
        let nearer = |p: (f64, Complex64), q: (f64, Complex64)| if p.0 <= q.0 { p } else { q };
        let (near_0, gamma_0) = nearer((p.from_0, p.gamma_0), (q.from_0, q.gamma_0));
        let (near_n, gamma_n) = nearer((p.from_n, p.gamma_n), (q.from_n, q.gamma_n));
        let is_from_0 = near_0 <= near_n;
        let boundaries = self.boundaries(is_from_0, p, q);
        let terms = match is_from_0 {
            true => boundaries.terms(n, kl, gamma_0, gamma_n),
            false => boundaries.terms(n, kl, gamma_n, gamma_0),
        };
        terms * self.factor
    }

    /// Makes the numbers of a ray that bounds take.
    pub fn direction(&self, ray: &Ray) -> Direction {
        let [of_0, of_n] = self.gamma_slopes(ray, ray);
        self.bound.direction(ray, [of_0[0].norm(), of_n[0].norm()])
    }

    /// The diffraction coefficient and its slopes, by the angles of both rays from the 0-face. The value is 0 for a leg that runs along a face.
    pub fn matrix(&self, p: &Ray, q: &Ray) -> DiffractionMatrix {
        let n = self.n;
        let kl = self.wavenumber_per_m * utd::distance_m(p.length_m, q.length_m);
        let (near_0, near_n) = (p.from_0 <= q.from_0, p.from_n <= q.from_n);
        let gamma_0 = if near_0 { p.gamma_0 } else { q.gamma_0 };
        let gamma_n = if near_n { p.gamma_n } else { q.gamma_n };
        let [slopes_0, slopes_n] = self.gamma_slopes(p, q);
        let is_from_0 = p.from_0.min(q.from_0) <= p.from_n.min(q.from_n);
        let boundaries = self.boundaries(is_from_0, p, q);
        let matrix = |gammas: [Complex64; 2], of_low, of_high: [Complex64; 2], p_is_low| {
            let slopes = GammaSlopes {
                gamma_0: of_low,
                gamma_n: of_high.map(|s| -s),
            };
            boundaries.slopes(n, kl, gammas[0], gammas[1], &slopes, p_is_low)
        };
        let matrix = match is_from_0 {
            true => matrix([gamma_0, gamma_n], slopes_0, slopes_n, near_0),
            false => matrix([gamma_n, gamma_0], slopes_n, slopes_0, near_n).turned_over(),
        };
        let mut matrix = matrix.scaled(self.factor);
        // The whole pattern is 0 along a face, whatever the other ray does.
        if p.is_slope_alone() {
            (matrix.value, matrix.by_second) = (Complex64::ZERO, Complex64::ZERO);
        }
        if q.is_slope_alone() {
            (matrix.value, matrix.by_first) = (Complex64::ZERO, Complex64::ZERO);
        }
        matrix
    }

    /// Slopes of the reflection coefficients of the 0-face and of the n-face with the angles of two rays from those: of legs along them, else 0.
    fn gamma_slopes(&self, p: &Ray, q: &Ray) -> [[Complex64; 2]; 2] {
        let along = |ray: &Ray, angle: f64| ray.slope != 0.0 && angle < ALONG_RAD;
        let pick = |along: bool, slope: Complex64| if along { slope } else { Complex64::ZERO };
        let of_0 = [p, q].map(|ray| pick(along(ray, ray.from_0), self.grazing[0]));
        let of_n = [p, q].map(|ray| pick(along(ray, ray.from_n), self.grazing[1]));
        [of_0, of_n]
    }

    /// Angles of two rays to the boundaries, counted from the 0-face, or with the faces exchanged. On a boundary the direct ray
    /// counts as free (a corner touched does not block) and a reflection as present on the 0-face (a wall owns its start) but not
    /// on the n-face (it does not own its end).
    fn boundaries(&self, is_from_0: bool, p: &Ray, q: &Ray) -> Boundaries {
        let ([phi_p, phi_q], face_0, face_n, tie) = match is_from_0 {
            true => ([p.from_0, q.from_0], &self.face_0, &self.face_n, -1.0),
            false => ([p.from_n, q.from_n], &self.face_n, &self.face_0, 1.0),
        };
        let mut b = Boundaries::new(self.n, phi_p, phi_q);
        b.shadow = settle(b.shadow, || self.turn_past_corner(p, q), -1.0);
        b.reflection_0 = settle(b.reflection_0, || -self.mixed(*face_0, p, q), tie);
        b.reflection_n = settle(b.reflection_n, || self.mixed(*face_n, p, q), tie);
        b
    }

    /// Positive when the corner is in the way of two rays half a turn apart: on which side of it
    /// the line from place to place passes, exactly as the test of that line decides.
    fn turn_past_corner(&self, p: &Ray, q: &Ray) -> f64 {
        let (low, high) = if p.from_0 <= q.from_0 { (p, q) } else { (q, p) };
        orient(low.place, high.place, self.point)
    }

    /// Sine of the sum of two rays' angles from a face, up to a positive factor: positive when
    /// the point of reflection is on the face, by the numbers that decide on the reflection.
    fn mixed(&self, (along, outward): (DVec2, DVec2), p: &Ray, q: &Ray) -> f64 {
        let (a, b) = (p.place - self.point, q.place - self.point);
        a.dot(along) * b.dot(outward) + b.dot(along) * a.dot(outward)
    }
}

/// The angle from a boundary, with its sign from `exact` where rounding could hide it; `tie` is
/// the side that the boundary itself belongs to.
fn settle(delta: f64, exact: impl FnOnce() -> f64, tie: f64) -> f64 {
    if delta.abs() > BOUNDARY_RAD {
        return delta;
    }
    let sign = exact();
    delta.abs().copysign(if sign == 0.0 { tie } else { sign })
}

impl Scene {
    /// Builds the wedges of all corners that diffract.
    pub(crate) fn wedges(&self, reflectors: &[Reflector], wavenumber_per_m: f64) -> Vec<Wedge> {
        (0..self.walls().len() as u32)
            .filter_map(|id| Some([id, self.other_face(id)?]))
            .map(|faces| Wedge::new(self, reflectors, faces, wavenumber_per_m))
            .collect()
    }

    /// The wall on the other side of the street at the start of wall `id`: its predecessor,
    /// unless another building touches the corner. `None` where the open angle between the two
    /// is not above pi: nothing goes around such a corner.
    pub(crate) fn other_face(&self, id: u32) -> Option<u32> {
        let wall = &self.walls()[id as usize];
        let corner = wall.a;
        let mut last = wall.previous;
        let mut is_open = true;
        let at_corner = |centre: DVec2, extent: DVec2| (corner - centre).abs().cmple(extent).all();
        self.index().for_each(at_corner, |other| {
            let Wall { a, b, .. } = self.walls()[other as usize];
            if b == corner {
                is_open &= orient(corner, wall.b, a) > 0.0;
                // Turning clockwise from `id`, the wall that is met first.
                if orient(corner, self.walls()[last as usize].a, a) > 0.0 {
                    last = other;
                }
            } else if a != corner && orient(a, b, corner) == 0.0 {
                // The corner touches the middle of a wall: half of the plane is gone.
                is_open &= !strictly_between(a, b, corner);
            }
            is_open
        });
        is_open.then_some(last)
    }
}
