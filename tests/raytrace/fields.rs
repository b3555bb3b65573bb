//! Fields of transmitters against what the tracer and exhaustive search say at single pixels.

use std::collections::HashSet;

use aps_raytrace::fields::{Field, FieldConfig, FieldGrid, FieldLink, FieldMap, Mirror};
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Location;
use aps_raytrace::{Area, Scene, TraceConfig, Tracer};
use aps_tests::brute_force::candidates;
use aps_tests::maps::real_cities;
use aps_tests::shapes::{block, city, city_scene, moved, rectangle, ring};
use proptest::prelude::*;

/// Decisions closer than this \[m\] may fall either way.
const TOLERANCE_M: f64 = 1e-6;

/// Rounding of lengths to f32 \[m\].
const ROUNDING_M: f64 = 2e-4;

fn map(scene: &Scene, pixel_m: f64) -> FieldMap<'_> {
    let config = FieldConfig {
        grid: FieldGrid::over(scene.area().unwrap(), pixel_m),
        ..FieldConfig::default()
    };
    FieldMap::new(scene, config).unwrap()
}

/// Numbers in a scattered order.
fn scattered(offset: u32) -> impl Iterator<Item = usize> {
    (0..).map(move |i: u32| ((i + offset).wrapping_mul(2_654_435_761) >> 8) as usize)
}

/// Some outdoor places on whole metres.
fn places(scene: &Scene, count: usize, offset: u32) -> Vec<DVec2> {
    let Area { min, max } = scene.area().unwrap();
    let size = (max - min).floor();
    let place = |i: usize| {
        let (x, y) = (i % size.x as usize, i / size.x as usize % size.y as usize);
        min.ceil() + DVec2::new(x as f64, y as f64)
    };
    let outdoor = |p: &DVec2| scene.locate(*p) == Location::Outdoor;
    let all = scattered(offset).map(place).filter(outdoor);
    all.take(count).collect()
}

/// Some pixels with an outdoor centre.
fn pixels(scene: &Scene, map: &FieldMap<'_>, count: usize) -> Vec<usize> {
    let on_grid = scattered(0).map(|i| i % map.grid().pixels());
    let outdoor = |pixel: &usize| scene.locate(map.grid().centre(*pixel)) == Location::Outdoor;
    on_grid.filter(outdoor).take(count).collect()
}

fn agrees(found: f64, expected: f64) -> bool {
    found == expected || (found - expected).abs() < ROUNDING_M
}

/// Compares what is in sight and lit with the tracer's paths. Returns how many lengths were compared, and how many decisions
/// were too close to call.
fn check_lit(scene: &Scene, map: &FieldMap<'_>, tx: DVec2, count: usize) -> (usize, usize) {
    let fields = map.transmitter(tx).unwrap();
    let in_sight = fields.in_sight();
    let [once, twice] = [Field::Once, Field::Twice].map(|field| fields.lengths_m(map, field));
    let tracer = Tracer::new(scene, TraceConfig::reflections_only(2)).unwrap();
    let (mut compared, mut close) = (0, 0);
    for pixel in pixels(scene, map, count) {
        let centre = map.grid().centre(pixel);
        if centre == tx {
            continue;
        }
        let paths = tracer.trace(tx, centre).unwrap().paths;
        let shortest = |order: usize| {
            let of_order = paths.iter().filter(|p| p.interactions.len() == order);
            of_order.map(|p| p.length_m).fold(f64::INFINITY, f64::min)
        };
        let sight = match in_sight[pixel] {
            1 => tx.distance(centre),
            _ => f64::INFINITY,
        };
        let all = [sight, once[pixel].into(), twice[pixel].into()];
        for (order, found) in all.into_iter().enumerate() {
            let expected = shortest(order);
            compared += usize::from(expected.is_finite());
            if agrees(found, expected) {
                continue;
            }
            // Nothing but a decision too close to call may come out otherwise.
            close += 1;
            let sequences = candidates(scene.walls(), tx, centre, order, TOLERANCE_M);
            let is_close = sequences.iter().any(|c| {
                c.walls.len() == order
                    && c.clearance_m.abs() < TOLERANCE_M
                    && agrees(c.length_m, found.min(expected))
            });
            assert!(
                is_close,
                "{tx} to {centre}, {order} reflections: {found} m instead of {expected} m"
            );
        }
    }
    (compared, close)
}

/// Returns true when two corners are at one place, through which exhaustion finds a way of width zero.
fn has_touching_corners(scene: &Scene) -> bool {
    let corners = scene
        .walls()
        .iter()
        .map(|w| [w.a.x, w.a.y].map(f64::to_bits));
    corners.collect::<HashSet<_>>().len() < scene.walls().len()
}

/// Shortest ways by exhaustion: all convex corners, all pairs, no tight strings.
struct Exhaustive<'s> {
    scene: &'s Scene,
    corners: Vec<DVec2>,
    steps_m: Vec<Vec<f64>>,
}

impl<'s> Exhaustive<'s> {
    fn new(scene: &'s Scene) -> Self {
        let convex = (0..scene.walls().len() as u32).filter(|&id| scene.is_convex(id));
        let corners: Vec<DVec2> = convex.map(|id| scene.walls()[id as usize].a).collect();
        let row = |&p: &DVec2| corners.iter().map(|&q| step_m(scene, p, q)).collect();
        Self {
            scene,
            steps_m: corners.iter().map(row).collect(),
            corners,
        }
    }

    /// Lengths to the corners (Bellman 1958).
    fn to_corners(&self, from: DVec2) -> Vec<f64> {
        let straight = self.corners.iter().map(|&c| step_m(self.scene, from, c));
        let mut lengths: Vec<f64> = straight.collect();
        loop {
            let before = lengths.clone();
            for (length, steps) in lengths.iter_mut().zip(&self.steps_m) {
                let over = steps
                    .iter()
                    .zip(&before)
                    .map(|(step, before)| step + before);
                *length = over.fold(*length, f64::min);
            }
            if lengths == before {
                return lengths;
            }
        }
    }

    fn shortest(&self, from: DVec2, to_corners: &[f64], to: DVec2) -> f64 {
        let over = self.corners.iter().zip(to_corners);
        let over = over.map(|(&corner, length)| length + step_m(self.scene, corner, to));
        over.fold(step_m(self.scene, from, to), f64::min)
    }
}

fn step_m(scene: &Scene, p: DVec2, q: DVec2) -> f64 {
    match p != q && scene.is_blocked(p, q, [None; 2]) {
        true => f64::INFINITY,
        false => p.distance(q),
    }
}

fn check_shortest(scene: &Scene, map: &FieldMap<'_>, tx: DVec2, count: usize) {
    let exhaustive = Exhaustive::new(scene);
    let to_corners = exhaustive.to_corners(tx);
    let fields = map.transmitter(tx).unwrap();
    let found = fields.lengths_m(map, Field::Geodesic);
    let mut longer = 0;
    let mut check = |to: DVec2, found: f64| {
        let expected = exhaustive.shortest(tx, &to_corners, to);
        longer += usize::from(found > expected && !agrees(found, expected));
        assert!(
            found >= expected || agrees(found, expected),
            "{tx} to {to}: {found} m instead of {expected} m"
        );
    };
    for pixel in pixels(scene, map, count) {
        check(map.grid().centre(pixel), found[pixel].into());
    }
    for rx in places(scene, count / 10, 77) {
        let receiver = map.receiver(rx).unwrap();
        let link = FieldLink {
            map,
            transmitter: &fields,
            receiver: &receiver,
            mirror: Mirror::default(),
        };
        check(rx, link.geodesic_m());
    }
    let most = match has_touching_corners(scene) {
        true => count / 10,
        false => 0,
    };
    assert!(longer <= most, "{longer} ways from {tx} are too long");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn fields_of_any_city_are_those_by_single_pixels(
        seed in 0_u64..1000,
        offset in 0_u32..10_000,
        pixel_m in prop::sample::select(vec![0.75, 1.0, 2.0]),
    ) {
        let scene = city_scene(130, seed);
        let map = map(&scene, pixel_m);
        let tx = places(&scene, 1, offset)[0];
        check_shortest(&scene, &map, tx, 300);
        let (_, close) = check_lit(&scene, &map, tx, 200);
        prop_assert!(close < 20, "{} of 200 too close to call", close);
    }
}

#[test]
fn a_whole_city_is_lit_as_single_pixels_are() {
    let scene = city_scene(256, 3);
    let map = map(&scene, 1.0);
    let (mut compared, mut close) = (0, 0);
    for tx in places(&scene, 4, 5) {
        let (lengths, ties) = check_lit(&scene, &map, tx, 2000);
        (compared, close) = (compared + lengths, close + ties);
        check_shortest(&scene, &map, tx, 1000);
    }
    assert!(
        compared > 1000 && close < compared / 100,
        "{compared} {close}"
    );
}

#[test]
fn real_cities_are_lit_as_single_pixels_are() {
    for (_, scene) in real_cities(&[0, 21]) {
        let map = map(&scene, 1.0);
        for tx in places(&scene, 2, 1) {
            let (compared, close) = check_lit(&scene, &map, tx, 700);
            assert!(compared > 50 && close < compared / 10, "{compared} {close}");
            check_shortest(&scene, &map, tx, 300);
        }
    }
}

#[test]
fn a_city_far_from_the_origin_is_lit_as_single_pixels_are() {
    let by = DVec2::new(385_000.0, 6_672_000.0);
    let footprints = moved(&city(130, 8).footprints().unwrap(), |p| p + by);
    let area = Area {
        min: by,
        max: by + 130.0,
    };
    let scene = Scene::new(&footprints, Some(area)).unwrap();
    let map = map(&scene, 1.0);
    for tx in places(&scene, 2, 9) {
        let (compared, _) = check_lit(&scene, &map, tx, 500);
        assert!(compared > 50, "{compared}");
        check_shortest(&scene, &map, tx, 300);
    }
}

fn square(side_m: f64) -> Option<Area> {
    Some(Area {
        min: DVec2::ZERO,
        max: DVec2::splat(side_m),
    })
}

#[test]
fn no_way_leads_between_two_corners_that_touch() {
    let houses = [
        rectangle(10.0, 10.0, 20.0, 20.0),
        rectangle(20.0, 20.0, 30.0, 30.0),
    ];
    let scene = Scene::new(&houses, square(40.0)).unwrap();
    let map = map(&scene, 1.0);
    let fields = map.transmitter(DVec2::new(25.0, 15.0)).unwrap();
    let lengths = fields.lengths_m(&map, Field::Geodesic);
    let at = |x: f64, y: f64| lengths[map.grid().pixel_at(DVec2::new(x, y)).unwrap()];
    // Around the corner at (20, 10), (10, 10) and (10, 20) to the other side, or as far the other way.
    let straight = |x: f64, y: f64, u: f64, v: f64| (x - u).hypot(y - v);
    let around = straight(25.0, 15.0, 20.0, 10.0) + 20.0 + straight(10.0, 20.0, 15.5, 24.5);
    assert!((f64::from(at(15.5, 24.5)) - around).abs() < ROUNDING_M);
    assert_eq!(map.corner_count(), 6);
}

#[test]
fn a_closed_courtyard_is_reached_from_inside_only() {
    let (outer, yard) = (
        ring([10.0, 30.0], [10.0, 30.0]),
        ring([15.0, 25.0], [15.0, 25.0]),
    );
    let scene = Scene::new(&[block(outer, yard)], square(40.0)).unwrap();
    let map = map(&scene, 1.0);
    let yard = map.grid().pixel_at(DVec2::new(20.0, 20.0)).unwrap();
    let street = map.grid().pixel_at(DVec2::new(35.0, 20.0)).unwrap();
    for (tx, [in_yard, in_street]) in [((5.0, 20.0), [false, true]), ((18.0, 20.0), [true, false])]
    {
        let fields = map.transmitter(DVec2::from(tx)).unwrap();
        for field in Field::ALL {
            let lengths = fields.lengths_m(&map, field);
            assert!(in_yard || lengths[yard].is_infinite());
            assert!(in_street || lengths[street].is_infinite());
        }
        let lengths = fields.lengths_m(&map, Field::Geodesic);
        assert_eq!(lengths[yard].is_finite(), in_yard);
        assert_eq!(lengths[street].is_finite(), in_street);
    }
}

#[test]
fn a_pixel_behind_a_wall_takes_over_its_neighbour_and_the_next_one_does_not() {
    let scene = Scene::new(&[rectangle(10.5, 10.0, 20.0, 30.0)], square(40.0)).unwrap();
    // Centres at whole metres: that at x = 11 is half a metre behind the wall.
    let grid = FieldGrid {
        first_m: DVec2::ZERO,
        pixel_m: 1.0,
        width: 40,
        height: 40,
    };
    let config = FieldConfig {
        grid,
        ..FieldConfig::default()
    };
    let map = FieldMap::new(&scene, config).unwrap();
    let fields = map.transmitter(DVec2::new(3.0, 20.0)).unwrap();
    let lengths = fields.lengths_m(&map, Field::Geodesic);
    let at = |x: f64| lengths[grid.pixel_at(DVec2::new(x, 20.0)).unwrap()];
    assert_eq!((at(10.0), at(11.0)), (7.0, 8.0));
    assert!(at(12.0).is_infinite());
}
