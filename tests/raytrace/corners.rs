//! Corners out of the ordinary: as thin as a sheet, nearly flat, shared by two buildings.

use std::f64::consts::PI;

use aps_raytrace::glam::DVec2;
use aps_raytrace::{
    Complex64, Footprint, Interaction, InteractionKind, Link, Material, TraceConfig, Tracer, utd,
};
use aps_tests::shapes::{points, polygon, rectangle, scene};

const WAVENUMBER_PER_M: f64 = 73.36;

fn diffracting() -> TraceConfig {
    TraceConfig {
        max_reflections: 0,
        dynamic_range_db: None,
        ..TraceConfig::default()
    }
}

/// D with reflection coefficients of concrete or of a perfect conductor.
fn coefficient(material: Material, n: f64, distance_m: f64, phi_1: f64, phi_2: f64) -> Complex64 {
    let reflector = material.at(3.5e9);
    let [gamma_0, gamma_n] =
        utd::incidence_cosines(n, phi_1, phi_2).map(|cos| reflector.reflection(cos));
    let k = WAVENUMBER_PER_M;
    utd::diffraction_coefficient(n, k, distance_m, phi_1, phi_2, gamma_0, gamma_n)
}

/// Pairs of directions over an open angle, both faces included.
fn directions(open_rad: f64) -> impl Iterator<Item = (f64, f64)> {
    let part = move |i: i32| open_rad * f64::from(i) / 31.0;
    (0..=31).flat_map(move |i| (0..=31).map(move |j| (part(i), part(j))))
}

#[test]
fn coefficient_is_finite_symmetric_and_bounded_from_flat_to_sheet() {
    let flat = [1.0, 1.0 + 1e-15, 1.0 + 1e-9, 1.01];
    for n in flat.into_iter().chain([1.5, 1.99, 2.0 - 1e-15, 2.0]) {
        for material in [Material::Concrete, Material::PerfectConductor] {
            for distance_m in [1e-6, 1.0, 1e5] {
                for (p, q) in directions(n * PI) {
                    let d = coefficient(material, n, distance_m, p, q);
                    assert!(d.norm() <= 2.0 * distance_m.sqrt(), "n {n}, {p}, {q}: {d}");
                    assert_eq!(d, coefficient(material, n, distance_m, q, p));
                }
            }
        }
    }
}

/// A sharper and sharper corner tends to the sheet: no jump at n = 2.
#[test]
fn slender_corner_tends_to_the_sheet() {
    for material in [Material::Concrete, Material::PerfectConductor] {
        for gap in [1e-2, 1e-4, 1e-8] {
            let mut worst = 0.0_f64;
            // At the same angles from the 0-face, those beyond the sharper corner's n-face and
            // within 0.2 rad of a boundary left out: these move.
            for (p, q) in directions(2.0 * PI) {
                let near_boundary = [(p - q).abs() - PI, p + q - PI, p + q - 3.0 * PI]
                    .iter()
                    .any(|d| d.abs() < 0.2);
                if p.max(q) > (2.0 - gap) * PI || near_boundary {
                    continue;
                }
                let sharp = coefficient(material, 2.0 - gap, 10.0, p, q);
                let sheet = coefficient(material, 2.0, 10.0, p, q);
                worst = worst.max((sharp - sheet).norm());
            }
            eprintln!("{material:?}, n = 2 - {gap}: D differs from the sheet's by {worst:.1e}");
            assert!(worst < 20.0 * gap);
        }
    }
}

/// A perfectly conducting corner that is hardly one diffracts hardly anything, away from the
/// reflection boundaries of its two faces, which all but coincide. With concrete the two faces
/// take different angles of incidence, so that the heuristic leaves a rest; it is measured here.
#[test]
fn nearly_flat_corner_hardly_diffracts() {
    let largest = |material, n: f64, off: f64| {
        directions(n * PI)
            .filter(|(p, q)| (p + q - PI).abs() > off && ((p - q).abs() - PI).abs() > off)
            .map(|(p, q)| coefficient(material, n, 10.0, p, q).norm())
            .fold(0.0, f64::max)
    };
    for bend in [1e-2, 1e-4, 1e-8] {
        let perfect = largest(Material::PerfectConductor, 1.0 + bend, 0.2);
        eprintln!("perfect conductor, n = 1 + {bend}: |D| up to {perfect:.1e} sqrt(m)");
        assert!(perfect < 10.0 * bend);
    }
    assert!(largest(Material::PerfectConductor, 1.0, 1e-9) < 1e-12);
    let flat = largest(Material::Concrete, 1.0, 0.0);
    let edge = largest(Material::Concrete, 1.5, 0.2);
    let below_direct_db = 20.0 * (flat * (2.0_f64 / 20.0).sqrt()).log10();
    eprintln!(
        "concrete, n = 1: |D| up to {flat:.1e} sqrt(m), {below_direct_db:.0} dB of the direct ray \
         over 20 m + 20 m; n = 1.5: up to {edge:.1e}"
    );
    assert!(flat < 0.05);
}

/// Both rays along a wall bent by a nanometre.
#[test]
fn wall_bent_by_an_atom_gives_no_nan() {
    let scene = scene(&[polygon("0,0 50,-1e-9 100,0 100,20 0,20")]);
    assert_eq!(scene.walls().len(), 5);
    for dynamic_range_db in [None, Some(60.0)] {
        let config = TraceConfig {
            dynamic_range_db,
            ..diffracting()
        };
        let tracer = Tracer::new(&scene, config).unwrap();
        for (tx, rx) in [((-10.0, 0.0), (110.0, 0.0)), ((-10.0, -3.0), (110.0, 0.0))] {
            let Link { paths, omitted, .. } = tracer.trace(tx.into(), rx.into()).unwrap();
            assert!(omitted.power.is_finite(), "{omitted:?}");
            assert!(paths.iter().all(|p| p.gain.is_finite()));
        }
    }
}

/// The diffraction points of all outdoor pairs around the buildings.
fn diffraction_points(buildings: &[Footprint]) -> Vec<DVec2> {
    let scene = scene(buildings);
    let tracer = Tracer::new(&scene, diffracting()).unwrap();
    let terminals: Vec<DVec2> = (-4..=14)
        .flat_map(|i| (-4..=14).map(move |j| DVec2::new(f64::from(i) * 2.3, f64::from(j) * 2.1)))
        .filter(|&p| scene.check_terminal(p).is_ok())
        .collect();
    let mut points: Vec<DVec2> = Vec::new();
    for (i, &tx) in terminals.iter().enumerate() {
        for &rx in terminals[..i].iter().step_by(7) {
            for path in tracer.trace(tx, rx).unwrap().paths {
                for i in &path.interactions {
                    assert_eq!(i.kind, InteractionKind::Diffraction);
                    if !points.contains(&i.point) {
                        points.push(i.point);
                    }
                }
            }
        }
    }
    sorted(points)
}

fn sorted(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|p, q| (p.x, p.y).partial_cmp(&(q.x, q.y)).unwrap());
    points
}

#[test]
fn houses_that_touch_diffract_at_the_corners_of_their_union() {
    let house = rectangle(0.0, 0.0, 10.0, 10.0);
    let table = [
        (
            "flush: at the ends of the row",
            [house.clone(), rectangle(10.0, 0.0, 20.0, 10.0)],
            "0,0 20,0 20,10 0,10",
        ),
        (
            "of different depth: at the step only outwards",
            [house.clone(), rectangle(10.0, 0.0, 20.0, 6.0)],
            "0,0 20,0 20,6 10,10 0,10",
        ),
        (
            "crossing bars: at their eight ends",
            [
                rectangle(8.0, 0.0, 12.0, 20.0),
                rectangle(0.0, 8.0, 20.0, 12.0),
            ],
            "8,0 12,0 8,20 12,20 0,8 0,12 20,8 20,12",
        ),
        (
            "a slanted house whose lower corner is inside the other one: not there",
            [
                rectangle(0.0, 0.0, 20.0, 10.0),
                polygon("10,5 18,13 10,21 2,13"),
            ],
            "0,0 20,0 20,10 0,10 18,13 10,21 2,13",
        ),
        (
            "that meet in one point: two corners of 90 degrees, both inward for the waves; nothing goes around",
            [house, rectangle(10.0, 10.0, 20.0, 20.0)],
            "0,0 10,0 0,10 20,10 20,20 10,20",
        ),
        (
            "a corner that touches the middle of a wall: no corner of the union",
            [
                rectangle(0.0, 0.0, 20.0, 6.0),
                polygon("10,6 16,12 10,18 4,12"),
            ],
            "0,0 20,0 20,6 0,6 16,12 10,18 4,12",
        ),
    ];
    for (case, houses, corners) in table {
        assert_eq!(
            diffraction_points(&houses),
            sorted(points(corners)),
            "{case}"
        );
    }
}

/// Two houses of a curved street touch at their front corners, a gap of 20 degrees behind: one
/// blunt wedge of the union between the outer faces, none of two right angles.
#[test]
fn houses_that_touch_at_the_front_make_one_blunt_wedge() {
    let gain = |buildings: &[Footprint], tx: (f64, f64), rx: (f64, f64)| {
        let scene = scene(buildings);
        let tracer = Tracer::new(&scene, diffracting()).unwrap();
        let paths = tracer.trace(tx.into(), rx.into()).unwrap().paths;
        let is_first = |i: &Interaction| i.point == DVec2::ZERO;
        let mut at_front = paths
            .iter()
            .filter(|p| p.interactions.first().is_some_and(is_first));
        let first = at_front.next().map(|p| p.gain);
        assert!(at_front.next().is_none(), "twice");
        first
    };
    // The outer faces fall or rise to the front by 5 m: bulging it is a wedge, and the same as without the gap; dented it is none.
    let row = |y: &str| {
        let a = polygon(&format!("0,0 -20,{y} -30,-20 -4,-20"));
        let b = polygon(&format!("0,0 4,-20 30,-20 20,{y}"));
        let union = polygon(&format!("0,0 -20,{y} -30,-20 30,-20 20,{y}"));
        ([a, b], [union])
    };
    let (tx, rx) = ((-9.0, 15.0), (11.0, 8.0));
    let (dented, union) = row("5");
    assert_eq!((gain(&dented, tx, rx), gain(&union, tx, rx)), (None, None));
    let (bulging, union) = row("-5");
    for (tx, rx) in [((-9.0, 15.0), (11.0, 8.0)), ((-30.0, 1.0), (25.0, -4.0))] {
        let without = gain(&union, tx, rx);
        assert!(without.is_some());
        assert_eq!(gain(&bulging, tx, rx), without);
    }
    // In the gap one is between two walls that meet: nothing comes out through the point.
    assert_eq!(gain(&bulging, (0.0, -10.0), (11.0, 8.0)), None);
}
