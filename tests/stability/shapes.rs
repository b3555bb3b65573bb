//! Footprints that strain the geometry: needles, circles, courtyards in courtyards, checkerboards,
//! gaps of nothing.

use std::f64::consts::TAU;

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Location, RepairKind};
use aps_raytrace::{
    Complex64, Footprint, InteractionKind, Material, TraceConfig, TraceError, Tracer, utd,
};
use aps_tests::links::with_chains;
use aps_tests::shapes::{block, moved, polygon, rectangle, ring, scene};

fn circle(centre: DVec2, radius: f64, vertices: u32) -> Footprint {
    let at = |i: u32| centre + DVec2::from_angle(TAU * f64::from(i) / f64::from(vertices)) * radius;
    Footprint::new((0..vertices).map(at).collect::<Vec<_>>())
}

/// A wall 100 m long that thins out to a point 1 mm, 1 um and 1 nm away from being flat. Above the
/// sliver limit it diffracts like the half-plane it tends to (interior angle 0, where the theory is
/// exact); below it is dropped, and the report says so. It never becomes a wall without thickness.
#[test]
fn needle_is_a_half_plane_or_reported_as_dropped() {
    let (tx, rx) = (DVec2::new(30.0, 5.0), DVec2::new(25.0, -8.0));
    for (base, is_kept) in [(1e-2, true), (1e-4, true), (1e-6, false), (1e-9, false)] {
        let scene = scene(&[polygon(&format!("0,0 100,0 100,{base}"))]);
        let dropped = scene.report().count(|k| matches!(k, RepairKind::Sliver));
        assert_eq!(
            (scene.walls().len(), dropped),
            if is_kept { (3, 0) } else { (0, 1) },
            "{base}"
        );
        if !is_kept {
            continue;
        }
        let config = TraceConfig {
            material: Material::PerfectConductor,
            max_reflections: 0,
            dynamic_range_db: None,
            ..with_chains()
        };
        let tracer = Tracer::new(&scene, config).unwrap();
        let paths = tracer.trace(tx, rx).unwrap().paths;
        let tip = paths
            .iter()
            .find(|p| p.interactions[0].point == DVec2::ZERO)
            .unwrap();
        let k = TAU * 3.5e9 / 299_792_458.0;
        let (s1, s2) = (tx.length(), rx.length());
        // Angles from the upper face.
        let (phi_1, phi_2) = (tx.to_angle(), TAU + rx.to_angle());
        let (distance_m, gamma) = (utd::distance_m(s1, s2), Complex64::from(-1.0));
        let d = utd::diffraction_coefficient(2.0, k, distance_m, phi_1, phi_2, gamma, gamma);
        let want = d.norm() / (s1 * s2 * (s1 + s2)).sqrt() / (2.0 * k);
        let error = (tip.gain.norm() / want - 1.0).abs();
        eprintln!("needle of {base} m over 100 m: {error:.1e} from the half-plane");
        assert!(error < base / 10.0);
    }
}

/// A tower of 10,000 vertices. A vertex of a convex outline sees its two neighbours and no other:
/// what is stored must grow with the number of vertices, not with its square, and setting up must
/// not cast rays between all 5e7 pairs. Around the tower no wave of four diffractions gets; finding
/// that out takes chains from 2854 lit corners, refused where they exceed the memory allowed.
#[test]
fn circle_of_ten_thousand_vertices_costs_in_proportion() {
    let scene = scene(&[circle(DVec2::ZERO, 50.0, 10_000)]);
    assert_eq!(scene.walls().len(), 10_000);
    let config = TraceConfig {
        max_wave_bytes: 1 << 26,
        ..with_chains()
    };
    let tracer = Tracer::new(&scene, config).unwrap();
    assert_eq!(tracer.corner_count(), 10_000);
    let tx = tracer.transmitter(DVec2::new(-80.0, 3.0)).unwrap();
    // From 80 m the tower shows acos(50/80) of its half turn to either side.
    let lit = 10_000.0 * (50.0_f64 / DVec2::new(80.0, 3.0).length()).acos() / (TAU / 2.0);
    for count in [tx.image_count(), tx.front_count()] {
        assert!((count as f64 - lit).abs() < 4.0, "{count} of {lit}");
    }
    let mut link = Default::default();
    let rx = tracer.receiver(DVec2::new(-40.0, 60.0)).unwrap();
    tracer.link(&tx, &rx, &mut link).unwrap();
    assert!(link.paths[0].is_line_of_sight());
    assert!(link.paths.iter().all(|p| p.gain.is_finite()));
    let behind = tracer.receiver(DVec2::new(70.0, -3.0)).unwrap();
    let refused = tracer.link(&tx, &behind, &mut link);
    assert!(matches!(
        refused,
        Err(TraceError::TooManyChains {
            diffractions: 2,
            ..
        })
    ));
}

/// Two round towers of 4000 vertices that face each other: thousands of corners see thousands.
/// Whatever is kept for pairs of pairs of them would take hundreds of gigabytes; instead the limit
/// says so, before the memory is taken. Without the fall-back nothing of it is needed.
#[test]
fn two_facing_circles_meet_a_stated_limit() {
    let towers = [
        circle(DVec2::ZERO, 50.0, 4_000),
        circle(DVec2::new(150.0, 0.0), 50.0, 4_000),
    ];
    let scene = scene(&towers);
    let error = Tracer::new(&scene, with_chains()).unwrap_err().to_string();
    assert!(error.contains("max_fallback_diffractions"), "{error}");
    let tracer = Tracer::new(&scene, TraceConfig::default()).unwrap();
    let (tx, rx) = (DVec2::new(75.0, 0.0), DVec2::new(75.0, 30.0));
    let link = tracer.trace(tx, rx).unwrap();
    assert!(link.paths.len() > 3);
}

/// Blocks with a courtyard in the courtyard of the next larger block, eight deep. A point belongs
/// to the innermost courtyard around it; waves stay in it, and the link says why there is no path.
#[test]
fn nested_courtyards_are_told_apart() {
    const DEPTH: u32 = 8;
    let square = |half: f64| ring([-half, half], [-half, half]);
    let around = |level: u32| {
        let half = 10.0 * f64::from(level + 1);
        block(square(half), square(half - 4.0))
    };
    let scene = scene(&(0..DEPTH).map(around).collect::<Vec<_>>());
    assert_eq!(scene.walls().len(), 8 * DEPTH as usize);
    let tracer = Tracer::new(&scene, with_chains()).unwrap();
    // Between two rings, and beyond the last.
    let places = |level: u32| {
        let x = if level == 0 {
            3.0
        } else {
            10.0 * f64::from(level) + 2.0
        };
        [DVec2::new(x, 1.0), DVec2::new(-x, -2.0)]
    };
    for p in 0..=DEPTH {
        for q in 0..=DEPTH {
            let link = tracer.trace(places(p)[0], places(q)[1]).unwrap();
            assert_eq!(link.is_enclosed, p != q, "{p} to {q}");
            assert_eq!(link.paths.is_empty(), p != q, "{p} to {q}");
        }
    }
}

/// A checkerboard of houses that touch at their corners. A corner where two houses meet is closed,
/// so each free square inside is a courtyard: no path leaves it, not even by diffraction, and the
/// link names the reason. A free square on the rim is open.
#[test]
fn checkerboard_with_touching_corners_lets_nothing_through() {
    for turn in [DVec2::X, DVec2::new(3.0, 4.0)] {
        let at = |x: f64, y: f64| turn.rotate(DVec2::new(x, y));
        let house = |i: i32| {
            let (x, y) = (10.0 * f64::from(i % 7), 10.0 * f64::from(i / 7));
            rectangle(x, y, x + 10.0, y + 10.0)
        };
        let is_built = |i: &i32| (i % 7 + i / 7) % 2 == 0;
        let houses: Vec<Footprint> = (0..49).filter(is_built).map(house).collect();
        let scene = scene(&moved(&houses, |p| turn.rotate(p)));
        let tracer = Tracer::new(&scene, with_chains()).unwrap();
        let (inside, beside) = (at(15.0, 24.0), at(35.0, 24.0));
        let (rim, away) = (at(15.0, 4.0), at(-20.0, -30.0));
        assert_eq!(scene.locate(inside), Location::Outdoor);
        for other in [beside, rim, away] {
            for (tx, rx) in [(inside, other), (other, inside)] {
                let link = tracer.trace(tx, rx).unwrap();
                assert!(link.paths.is_empty(), "{tx} -> {rx}: {:?}", link.paths);
                assert!(link.is_enclosed, "{tx} -> {rx}");
            }
        }
        let link = tracer.trace(rim, away).unwrap();
        assert!(!link.paths.is_empty() && !link.is_enclosed);
        // Its own four walls.
        let link = tracer.trace(inside, at(12.0, 27.0)).unwrap();
        assert!(link.paths.len() > 5 && link.paths[0].is_line_of_sight());
        let mut all = link.paths.iter().flat_map(|p| &p.interactions);
        assert!(all.all(|i| i.kind == InteractionKind::Reflection));
    }
}

/// Houses 1e-12 m apart: no gap that a wavelength of 9 cm could pass and less than the
/// coordinates of a map resolve. The row is one house: the same walls, the same paths, and no
/// terminal fits between.
#[test]
fn houses_a_picometre_apart_are_one_row() {
    for gap in [1e-12, -1e-12] {
        let row = [
            rectangle(0.0, 0.0, 10.0, 10.0),
            rectangle(10.0 + gap, 0.0, 20.0, 10.0),
            rectangle(20.0, 10.0 + gap, 30.0, 20.0),
        ];
        let two = scene(&row[..2]);
        assert_eq!(two.walls().len(), 4, "{:?}", two.walls());
        let between = two.locate(DVec2::new(10.0 + gap / 2.0, 5.0));
        assert!(matches!(between, Location::Inside { .. }));
        let tracer = Tracer::new(&two, with_chains()).unwrap();
        let (tx, rx) = (DVec2::new(10.0, -5.0), DVec2::new(10.0, 15.0));
        let link = tracer.trace(tx, rx).unwrap();
        assert!(!link.paths.iter().any(|p| p.is_line_of_sight()));
        let mut all = link.paths.iter().flat_map(|p| &p.interactions);
        assert!(all.all(|i| i.point.x < 1e-9 || i.point.x > 20.0 - 1e-9));
        // Corner to corner, and shifted along a wall.
        let (p, q) = (DVec2::new(15.0, 15.0), DVec2::new(25.0, 5.0));
        assert!(scene(&row).is_blocked(p, q), "{gap}");
        let shifted = [
            rectangle(0.0, 0.0, 10.0, 10.0),
            rectangle(10.0 + gap, 3.0, 20.0, 17.0),
        ];
        let shifted = scene(&shifted);
        for x in [10.0, 10.0 + gap / 2.0, 10.0 + gap] {
            let (p, q) = (DVec2::new(x, -1.0), DVec2::new(x, 11.0));
            assert!(shifted.is_blocked(p, q), "{gap} {x}");
        }
    }
}

/// Footprints without any area: all vertices on one line, along an axis and not. They are dropped
/// with a report and leave free space.
#[test]
fn collinear_footprints_leave_free_space() {
    let flat = |d: DVec2| Footprint::new([0.0, 3.0, 1.0, 7.0, 2.0].map(|t| d * t));
    let scene = scene(&[DVec2::X, DVec2::Y, DVec2::new(3.0, 4.0)].map(flat));
    assert!(scene.walls().is_empty());
    assert_eq!(scene.report().count(|k| matches!(k, RepairKind::Sliver)), 3);
    let tracer = Tracer::new(&scene, with_chains()).unwrap();
    let (tx, rx) = (DVec2::new(-1.0, -1.0), DVec2::new(5.0, 5.0));
    let link = tracer.trace(tx, rx).unwrap();
    assert_eq!(link.paths.len(), 1);
}
