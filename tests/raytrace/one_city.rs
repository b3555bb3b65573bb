//! The image of a map shows the city that is traced, whatever rings it was made from.

use aps_data::{Raster, RasterGrid};
use aps_raytrace::glam::DVec2;
use aps_raytrace::predicates::orient;
use aps_raytrace::scene::{Footprint, Location, Scene};
use aps_tests::shapes;
use proptest::prelude::*;

const SIDE: i32 = 20;

/// A vertex on a grid so coarse that rings touch, cross and repeat each other often.
fn vertex(steps: i32) -> impl Strategy<Value = DVec2> {
    let coordinate =
        move || (-2 * steps..(SIDE + 2) * steps).prop_map(move |v| f64::from(v) / f64::from(steps));
    (coordinate(), coordinate()).prop_map(DVec2::from)
}

/// Any closed walk of some vertices, sometimes twice around.
fn ring() -> impl Strategy<Value = Vec<DVec2>> {
    let walk = |steps| prop::collection::vec(vertex(steps), 3..9);
    let rings = prop_oneof![walk(1), walk(3), walk(16), rectangle()];
    (rings, prop::bool::weighted(0.1)).prop_map(|(ring, is_twice)| match is_twice {
        true => ring.repeat(2),
        false => ring,
    })
}

fn rectangle() -> impl Strategy<Value = Vec<DVec2>> {
    let corners = (vertex(1), vertex(1), any::<bool>());
    corners.prop_map(|(a, b, is_reversed)| {
        let mut ring = vec![a, DVec2::new(b.x, a.y), b, DVec2::new(a.x, b.y)];
        if is_reversed {
            ring.reverse();
        }
        ring
    })
}

fn footprint() -> impl Strategy<Value = Footprint> {
    let holes = prop::collection::vec(ring(), 0..4);
    (ring(), holes).prop_map(|(outer, holes)| Footprint {
        outer,
        holes,
        material: None,
    })
}

/// Tells if a wall has a point of the open segment, by looking at all walls.
fn is_cut(scene: &Scene, p: DVec2, q: DVec2) -> bool {
    scene.walls().iter().any(|wall| {
        let (a, b) = (wall.a, wall.b);
        let sign = |v: f64| i32::from(v > 0.0) - i32::from(v < 0.0);
        let of_segment = sign(orient(a, b, p)) * sign(orient(a, b, q));
        let of_wall = sign(orient(p, q, a)) * sign(orient(p, q, b));
        let is_on_line = orient(p, q, a) == 0.0 && orient(p, q, b) == 0.0;
        match is_on_line {
            true => a.x.max(b.x) > p.x.min(q.x) && a.x.min(b.x) < p.x.max(q.x),
            false => of_segment < 0 && of_wall <= 0,
        }
    })
}

fn check(footprints: &[Footprint], metres_per_pixel: f64) -> Result<(), TestCaseError> {
    // A ring of one or two places is refused, whatever else there is.
    let scene = Scene::new(footprints, None);
    prop_assume!(scene.is_ok());
    let scene = scene.unwrap();
    let outlines = scene.outlines();
    let in_numbers = |ring: &Vec<DVec2>| ring.iter().map(|p| p.to_array()).collect();
    let outlines: Vec<Vec<[f64; 2]>> = outlines.iter().map(in_numbers).collect();
    let side = (f64::from(SIDE) / metres_per_pixel) as usize;
    let grid = RasterGrid {
        width: side,
        height: side,
        metres_per_pixel,
    };
    let raster = Raster::of_outlines(&outlines, grid).unwrap();
    for y in 0..side {
        for x in 0..side {
            let at = |dx: f64| DVec2::new(x as f64 + dx, y as f64) * metres_per_pixel;
            let (left, centre, right) = (at(-0.5), at(0.0), at(0.5));
            let is_set = raster.row(y)[x] == 1;
            let is_cut = is_cut(&scene, left, right);
            let is_inside = matches!(scene.locate(centre), Location::Inside { .. });
            prop_assert_eq!(
                is_set,
                is_cut || is_inside,
                "pixel {}, {} of {:?}",
                x,
                y,
                outlines
            );
            prop_assert_eq!(is_set, scene.touches_building(left, right));
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn image_shows_the_traced_city_for_any_rings(
        footprints in prop::collection::vec(footprint(), 1..6),
        metres_per_pixel in prop_oneof![Just(1.0), Just(0.7), Just(2.3)],
    ) {
        check(&footprints, metres_per_pixel)?;
    }
}

fn square(low: f64, high: f64) -> Vec<DVec2> {
    shapes::ring([low, high], [low, high])
}

fn walls_of(outer: Vec<DVec2>, hole: Vec<DVec2>) -> (Vec<Vec<DVec2>>, String) {
    let scene = shapes::scene(&[shapes::block(outer, hole)]);
    (scene.outlines(), scene.report().to_string())
}

#[test]
fn hole_around_the_outer_ring_changes_places_with_it() {
    let (right, report) = walls_of(square(0.0, 50.0), square(10.0, 40.0));
    assert_eq!((right.len(), report.as_str()), (2, "1 reoriented"));
    let (found, report) = walls_of(square(10.0, 40.0), square(0.0, 50.0));
    assert_eq!(found, right);
    assert!(
        report.ends_with("1 hole taken for an outer ring"),
        "{report}"
    );
}

#[test]
fn hole_beside_its_building_changes_nothing() {
    let (found, _) = walls_of(square(0.0, 20.0), square(30.0, 60.0));
    assert_eq!(found, [square(0.0, 20.0)]);
}

#[test]
fn building_that_fills_a_courtyard_is_told() {
    let block = shapes::block(square(0.0, 50.0), square(10.0, 40.0));
    for yard in [square(10.0, 40.0), square(10.0, 39.0)] {
        let is_whole = yard == square(10.0, 40.0);
        let scene = Scene::new(&[Footprint::new(yard), block.clone()], None).unwrap();
        let report = scene.report().to_string();
        assert_eq!(
            report.contains("1 courtyard filled by a building"),
            is_whole,
            "{report}"
        );
    }
}
