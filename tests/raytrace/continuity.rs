//! The total field where a ray of geometrical optics appears or goes: diffraction makes up for it.
//!
//! One triangular building, its corner at the origin, the other two far away. The field is the
//! sum of all paths, as a user gets them.

use std::f64::consts::PI;

use aps_raytrace::glam::DVec2;
use aps_raytrace::{Complex64, Footprint, Material, Scene, Tracer};
use aps_tests::links::{corners, decibels, one_of_each, total_field};
use aps_tests::shapes::{rectangle, scene};

/// Length of the building's sides \[m\].
const SIDE_M: f64 = 1e3;

const MATERIALS: [Material; 2] = [Material::Concrete, Material::PerfectConductor];

/// A corner at the origin; the 0-face runs along `start_rad`, the building from there
/// counter-clockwise over `interior_rad`.
struct Corner {
    scene: Scene,
    start_rad: f64,
    open_rad: f64,
}

impl Corner {
    fn new(interior_rad: f64) -> Self {
        // An odd angle, so that nothing is aligned with an axis.
        let start_rad = 0.3;
        let at = |angle: f64| DVec2::from_angle(angle) * SIDE_M;
        let points = [DVec2::ZERO, at(start_rad), at(start_rad + interior_rad)];
        Self {
            scene: scene(&[Footprint::new(points)]),
            start_rad,
            open_rad: 2.0 * PI - interior_rad,
        }
    }

    /// The point at angle `phi` from the 0-face.
    fn at(&self, phi: f64, distance_m: f64) -> DVec2 {
        DVec2::from_angle(self.start_rad - phi) * distance_m
    }

    /// The angles at which the direct ray or a reflected one ends, for a source at `phi`, more than 1e-3 rad
    /// off the faces.
    fn boundaries(&self, phi: f64) -> impl Iterator<Item = f64> {
        let open = self.open_rad;
        [PI + phi, phi - PI, PI - phi, 2.0 * open - PI - phi]
            .into_iter()
            .filter(move |b| (1e-3..open - 1e-3).contains(b))
    }
}

/// Field, and number of rays of geometrical optics.
fn field(tracer: &Tracer, tx: DVec2, rx: DVec2) -> (Complex64, usize) {
    let paths = tracer.trace(tx, rx).unwrap().paths;
    let optical = paths.iter().filter(|p| corners(p) == 0).count();
    (total_field(&paths), optical)
}

/// Steps over each boundary of a corner; returns the largest jump of the level [dB] and how many
/// boundaries there were.
fn largest_jump(interior_rad: f64, material: Material, distances_m: [f64; 2]) -> (f64, usize) {
    let corner = Corner::new(interior_rad);
    let tracer = Tracer::new(&corner.scene, one_of_each(material)).unwrap();
    let (mut worst, mut count) = (0.0_f64, 0);
    for part in [0.04, 0.11, 0.23, 0.37, 0.5, 0.61, 0.78, 0.95] {
        let phi = part * corner.open_rad;
        let tx = corner.at(phi, distances_m[0]);
        for boundary in corner.boundaries(phi) {
            count += 1;
            for step in [1e-8, 1e-9, 1e-10, 1e-11] {
                let (before, m) = field(&tracer, tx, corner.at(boundary - step, distances_m[1]));
                let (after, n) = field(&tracer, tx, corner.at(boundary + step, distances_m[1]));
                assert_eq!(m.abs_diff(n), 1, "no ray ends at {boundary}");
                worst = worst.max(decibels(before, after).abs());
            }
        }
    }
    (worst, count)
}

#[test]
fn level_is_continuous_over_all_boundaries_of_wedges() {
    eprintln!("largest jump over shadow and reflection boundaries [dB]");
    for material in MATERIALS {
        for distances_m in [[1.0, 1.0], [100.0, 100.0], [1.0, 100.0]] {
            let (mut worst, mut count) = (0.0_f64, 0);
            for interior_deg in (30..=150).step_by(15) {
                let interior = f64::from(interior_deg).to_radians();
                let (jump, boundaries) = largest_jump(interior, material, distances_m);
                worst = worst.max(jump);
                count += boundaries;
            }
            eprintln!("{material:?}, {distances_m:?} m: {worst:.1e} over {count} boundaries");
            assert!(worst < 1e-3 && count > 100);
        }
    }
}

#[test]
fn level_is_continuous_over_all_boundaries_of_a_half_plane() {
    for material in MATERIALS {
        for distance_m in [1.0, 100.0] {
            // A needle: 1 mm wide at the end, 1 km away.
            let (jump, count) = largest_jump(1e-6, material, [distance_m; 2]);
            eprintln!("half plane, {material:?}, {distance_m} m: jump {jump:.1e} dB");
            assert!(jump < 1e-3 && count == 14);
        }
    }
}

/// Triangles with a corner at the origin and whole metres everywhere; both walls there point
/// along directions with whole lengths, so that mirror images are whole too.
const WHOLE: [[(i32, i32); 2]; 6] = [
    [(40_000, 0), (0, 40_000)],
    [(0, -40_000), (40_000, 0)],
    [(30_000, 40_000), (-40_000, 30_000)],
    [(40_000, 0), (-30_000, 40_000)],
    [(40_000, 0), (24_000, 7_000)],
    [(24_000, -7_000), (40_000, 1)],
];

fn whole(p: (i32, i32)) -> DVec2 {
    DVec2::new(p.0.into(), p.1.into())
}

/// Mirrors at the wall along `d` through the origin; whole for terminals in multiples of 25 m.
fn mirror(p: DVec2, d: DVec2) -> DVec2 {
    d * (2.0 * p.dot(d) / d.length_squared()) - p
}

/// Exactly on a boundary the corner is touched: one side must own the case, the same for the ray
/// that ends and for the diffracted one. A mismatch would be half a ray too much or too little.
#[test]
fn exactly_on_a_boundary_the_level_is_that_beside_it() {
    let (mut worst, mut count) = (0.0_f64, [0; 3]);
    for (walls, material) in WHOLE.iter().flat_map(|w| MATERIALS.map(|m| (w, m))) {
        let [d, e] = walls.map(whole);
        let scene = scene(&[Footprint::new([DVec2::ZERO, d, e])]);
        let tracer = Tracer::new(&scene, one_of_each(material)).unwrap();
        let is_free = |p: DVec2| scene.check_terminal(p).is_ok();
        for (i, j) in (-3..=3).flat_map(|i| (-3..=3).map(move |j| (i, j))) {
            let tx = whole((25 * i, 25 * j));
            // Grazing along a wall is another matter.
            if tx.perp_dot(d) == 0.0 || tx.perp_dot(e) == 0.0 || !is_free(tx) {
                continue;
            }
            // Straight through the corner, and reflected in it by either wall.
            let shadow = -tx;
            let reflections = [(d, 1), (e, -1)].map(|(wall, side)| {
                let in_front = f64::from(side) * wall.perp_dot(tx) < 0.0;
                in_front.then(|| -mirror(tx, wall))
            });
            let kinds = [Some(shadow), reflections[0], reflections[1]];
            for (kind, towards) in kinds.into_iter().enumerate() {
                let Some(towards) = towards else { continue };
                for scale in [1.0, 0.4, 3.0] {
                    let rx = (towards * scale).round();
                    if rx == tx || rx.perp_dot(towards) != 0.0 || !is_free(rx) {
                        continue;
                    }
                    if rx.perp_dot(d) == 0.0 || rx.perp_dot(e) == 0.0 {
                        continue;
                    }
                    let (on, _) = field(&tracer, tx, rx);
                    let beside = rx.perp() * 1e-8;
                    for other in [rx + beside, rx - beside] {
                        let (off, _) = field(&tracer, tx, other);
                        worst = worst.max(decibels(on, off).abs());
                    }
                    count[kind] += 1;
                }
            }
        }
    }
    eprintln!("on the boundary and beside it: {worst:.1e} dB apart in {count:?} cases");
    assert!(worst < 1e-3 && count.iter().all(|&n| n > 100));
}

/// A reflected ray that touches the corner: its point of reflection is rounded, the decision is
/// not. The block stands in the first quadrant, a wall along y = -50 m reflects.
#[test]
fn exactly_on_the_boundary_of_a_reflected_ray_the_level_is_that_beside_it() {
    let wall = rectangle(-500.0, -60.0, 500.0, -50.0);
    let scene = scene(&[rectangle(0.0, 0.0, 40.0, 40.0), wall]);
    let (mut worst, mut count) = (0.0_f64, 0);
    for material in MATERIALS {
        let tracer = Tracer::new(&scene, one_of_each(material)).unwrap();
        for (x, y) in (1..=24).flat_map(|x| (1..=40).map(move |y| (x, -y))) {
            let tx = whole((x, y));
            // The image is at (x, -100 - y); beyond the corner, a multiple of the opposite.
            let image = whole((x, -100 - y));
            for scale in [1.0, 0.5, 0.2] {
                let rx = -image * scale;
                if rx != rx.round() || rx.x == 0.0 {
                    continue;
                }
                let (on, _) = field(&tracer, tx, rx);
                let beside = rx.perp() * 1e-9;
                let ((p, m), (q, n)) = (
                    field(&tracer, tx, rx + beside),
                    field(&tracer, tx, rx - beside),
                );
                assert_eq!(m.abs_diff(n), 1, "no ray ends at {rx}");
                let jump = decibels(on, p).abs().max(decibels(on, q).abs());
                // Paths by other corners, 60 dB weaker, end here too: no second diffraction.
                assert!(jump < 0.1, "{tx} -> {rx}: {jump} dB");
                worst = worst.max(jump);
                count += 1;
            }
        }
    }
    eprintln!("on a reflected ray's boundary and beside it: {worst:.1e} dB apart in {count} cases");
    assert!(count > 1000);
}
