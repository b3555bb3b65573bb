//! Slits too narrow for a wave are closed, whatever the houses' order and direction; wider streets keep every bit.

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{Area, Footprint, RepairKind, Scene, SceneConfig, Wall};
use aps_tests::shapes::{points, ring as rectangle};
use proptest::prelude::*;

fn scene(rings: &[Vec<DVec2>], close_gaps_m: f64) -> Scene {
    let footprints: Vec<Footprint> = rings.iter().map(|r| Footprint::new(r.clone())).collect();
    let config = SceneConfig {
        area: Some(Area::RADIOMAPSEER),
        close_gaps_m,
    };
    Scene::with_config(&footprints, &config).unwrap()
}

fn gaps(scene: &Scene) -> usize {
    scene
        .report()
        .count(|k| matches!(k, RepairKind::Gap { .. }))
}

#[test]
fn terrace_with_slits_is_the_terrace_without() {
    let whole = scene(&[rectangle([40.0, 200.0], [100.0, 120.0])], 0.0);
    for width_m in [1e-6, 1e-3, 0.01, 0.039] {
        let houses = [
            rectangle([40.0, 120.0], [100.0, 120.0]),
            rectangle([120.0 + width_m, 160.0], [100.0, 120.0]),
            rectangle([160.0 + width_m, 200.0], [100.0, 120.0]),
        ];
        let closed = scene(&houses, 0.04);
        assert_eq!(closed.outlines(), whole.outlines(), "{width_m} m");
        assert_eq!(closed.report().to_string(), "2 gaps closed");
        let [p, q] = [60.0, 180.0].map(|y| DVec2::new(120.0 + width_m / 2.0, y));
        assert!(closed.is_blocked(p, q));
        assert!(!scene(&houses, 0.0).is_blocked(p, q));
    }
}

#[test]
fn wider_slit_stays_open() {
    let houses = [
        rectangle([40.0, 120.0], [100.0, 120.0]),
        rectangle([120.05, 200.0], [100.0, 120.0]),
    ];
    assert_eq!(scene(&houses, 0.04).walls(), scene(&houses, 0.0).walls());
    assert_eq!(gaps(&scene(&houses, 0.06)), 1);
}

#[test]
fn courtyard_behind_a_slit_is_closed() {
    let c_shape = "60,60 180,60 180,180 120.01,180 120.01,160 160,160 160,80 80,80 80,160 120,160 120,180 60,180";
    let ring = points(c_shape);
    let yard = DVec2::splat(120.0);
    assert_eq!(
        scene(std::slice::from_ref(&ring), 0.0).courtyard_of(yard),
        None
    );
    let closed = scene(&[ring], 0.04);
    assert_eq!(closed.courtyard_of(yard), Some(0));
    assert_eq!(closed.walls().len(), 8);
}

#[test]
fn thin_wall_and_touching_houses_are_left_as_they_are() {
    let thin = rectangle([50.0, 50.001], [50.0, 90.0]);
    // A wedge of street between two houses that touch at its end.
    let left = rectangle([100.0, 120.0], [50.0, 60.0]);
    let right = points("120,50 140,50 140,60 120.03,60");
    let houses = [thin, left, right];
    assert_eq!(scene(&houses, 0.04).walls(), scene(&houses, 0.0).walls());
}

#[test]
fn slits_are_measured_against_the_houses() {
    let pair = |x: [f64; 4], y| {
        let houses = [[x[0], x[1]], [x[2], x[3]]].map(|x| rectangle(x, y));
        gaps(&scene(&houses, 0.04))
    };
    // A model city in millimetres keeps its streets.
    assert_eq!(pair([0.0, 0.1, 0.112, 0.2], [0.0, 0.1]), 0);
    // Two small houses alone are closed like a city.
    assert_eq!(pair([110.0, 112.0, 112.03, 114.0], [110.0, 112.0]), 1);
}

#[test]
fn bay_behind_a_short_wall_is_no_slit() {
    // A chamfer of 14 mm in a concave corner, and a dead end of 1 cm.
    let chamfer = points("10,10 40,10 40,20 20.01,20 20,20.01 20,40 10,40");
    let notch = points("60,10 90,10 90,20 70.01,20 70.01,15 70,15 70,20 60,20");
    let rings = [chamfer, notch];
    assert_eq!(scene(&rings, 0.04).walls(), scene(&rings, 0.0).walls());
}

#[test]
fn fillings_that_meet_leave_no_void() {
    let houses = [
        rectangle([10.0, 20.0], [10.0, 20.0]),
        rectangle([20.03, 30.0], [10.0, 20.0]),
        rectangle([10.0, 30.0], [20.03, 30.0]),
    ];
    let closed = scene(&houses, 0.04);
    assert_eq!(gaps(&closed), 3);
    assert_eq!(closed.outlines().len(), 1, "{:?}", closed.outlines());
}

/// The slit's mouth lies where the wall beside it has 9.6 um left.
#[test]
fn a_filling_leaves_no_splinter_of_a_wall() {
    let (x, y) = (128.006_876_861_471_65, 123.039_414_011_946_23);
    let houses = [
        rectangle([108.0, 128.0], [123.0, 133.0]),
        rectangle([x, 158.0], [y, y + 14.0]),
    ];
    let closed = scene(&houses, 0.04);
    assert_eq!(gaps(&closed), 1);
    let shortest = closed
        .walls()
        .iter()
        .map(Wall::length_m)
        .fold(f64::INFINITY, f64::min);
    assert!(shortest > 1e-4, "{shortest} m: {:?}", closed.outlines());
}

#[test]
fn impossible_width_is_refused() {
    for close_gaps_m in [-1.0, 21.0, 1e300, f64::NAN, f64::INFINITY] {
        let config = SceneConfig {
            area: None,
            close_gaps_m,
        };
        let error = Scene::with_config(&[], &config).unwrap_err().to_string();
        assert!(error.contains("cannot be closed"), "{error}");
    }
}

/// Two turned houses with a slit between them, and the two ends of a line of sight through it.
fn houses_with_slit() -> impl Strategy<Value = ([Vec<DVec2>; 2], f64, [DVec2; 2])> {
    (0.0..std::f64::consts::TAU, -3.0..-1.42_f64, -6.0..6.0_f64).prop_map(
        |(angle, exponent, shift)| {
            let width_m = 10_f64.powf(exponent);
            let turned = |p: DVec2| DVec2::splat(128.0) + DVec2::from_angle(angle).rotate(p);
            let left = rectangle([-20.0, 0.0], [-5.0, 5.0]);
            let right = rectangle([width_m, 30.0], [shift - 7.0, shift + 7.0]);
            let houses = [left, right].map(|house| house.into_iter().map(turned).collect());
            let ends = [-30.0, 30.0].map(|y| turned(DVec2::new(width_m / 2.0, y)));
            (houses, width_m, ends)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn slit_between_turned_houses_is_closed_in_any_order((houses, width_m, ends) in houses_with_slit()) {
        let [p, q] = ends;
        prop_assert!(!scene(&houses, 0.0).is_blocked(p, q));
        let closed = scene(&houses, 0.04);
        prop_assert!(closed.is_blocked(p, q), "{} m", width_m);
        let [a, b] = houses.clone();
        let swapped = [b.iter().rev().copied().collect(), a];
        prop_assert_eq!(closed.outlines(), scene(&swapped, 0.04).outlines());
        prop_assert_eq!(scene(&houses, width_m / 2.0).outlines(), scene(&houses, 0.0).outlines());
        // Only ends of both walls at the slit are left, and two short walls at its mouths.
        prop_assert!(closed.walls().len() <= 10, "{:?}", closed.outlines());
        prop_assert!(closed.walls().iter().all(|w| w.length_m() > 1e-4), "{:?}", closed.outlines());
    }
}
