//! The polar view: against a script of another hand, exhaustive search, mirror images, and on scenes of any shape.

use aps_raytrace::glam::DVec2;
use std::collections::BTreeMap;

use aps_raytrace::polar::{
    FEATURES, Fan, KINDS, Mirror, PER_WAY, PolarError, PolarLink, PolarMap, ReceiverRays,
    TransmitterWays,
};
use aps_raytrace::scene::Location;
use aps_raytrace::{Area, Footprint, Scene};
use aps_tests::links::outdoor_points;
use aps_tests::shapes::{block, city, city_scene, moved, ring};
use proptest::prelude::*;
use serde_json::Value;

const SIDE_M: f64 = 256.0;

/// Outdoor points that are not on the grid of walls, exact in binary: a ray through a corner takes either side.
fn off_grid(scene: &Scene, count: usize, offset: u32) -> Vec<DVec2> {
    let points = outdoor_points(scene, 2 * count, offset).into_iter();
    let moved = points.map(|p| p + DVec2::new(0.316_406_25, 0.441_406_25));
    let outdoor = moved.filter(|&p| scene.locate(p) == Location::Outdoor);
    outdoor.take(count).collect()
}

fn prepare(map: &PolarMap<'_>, points: &[DVec2]) -> (Vec<TransmitterWays>, Vec<ReceiverRays>) {
    let (tx, rx) = points.split_at(points.len() / 2);
    let tx = tx.iter().map(|&p| map.transmitter(p).unwrap());
    let rx = rx.iter().map(|&p| map.receiver(p).unwrap());
    (tx.collect(), rx.collect())
}

/// Features of ways by link, direction and kind.
type Ways = BTreeMap<[usize; 3], Vec<f32>>;

/// Ways of all links of the first half of the points with the second.
fn ways(map: &PolarMap<'_>, points: &[DVec2], mirror: Mirror) -> Ways {
    let (tx, rx) = prepare(map, points);
    let pairs = tx.iter().flat_map(|tx| rx.iter().map(move |rx| (tx, rx)));
    let mut ways = Ways::new();
    for (link, (transmitter, receiver)) in pairs.enumerate() {
        let mut found = Vec::new();
        let seen = PolarLink {
            map,
            transmitter,
            receiver,
        };
        seen.ways(&mut found).unwrap();
        mirror.turn_ways(&mut found, map.fan().directions);
        let number = |way: &[f32]| [way[FEATURES] as usize, way[FEATURES + 1] as usize];
        assert!(found.chunks_exact(PER_WAY).is_sorted_by_key(number));
        for way in found.chunks_exact(PER_WAY) {
            let [direction, kind] = number(way);
            assert!(kind < map.fan().way_kinds() && direction < map.fan().directions);
            let features = way[..FEATURES].to_vec();
            assert!(ways.insert([link, direction, kind], features).is_none());
        }
    }
    ways
}

/// Values that differ by more than `tolerance`; those of a way are zeros where there is none.
fn differing(p: &Ways, q: &Ways, tolerance: f32) -> usize {
    let none = vec![0.0; FEATURES];
    let both = p.keys().chain(q.keys().filter(|key| !p.contains_key(*key)));
    let of_way = |key: &[usize; 3]| {
        let [p, q] = [p, q].map(|ways| ways.get(key).unwrap_or(&none));
        let is_same = |p: f32, q: f32| (p - q).abs() <= tolerance;
        // NaN differs from all.
        p.iter().zip(q).filter(|&(&p, &q)| !is_same(p, q)).count()
    };
    both.map(of_way).sum()
}

#[test]
fn every_way_is_that_of_the_script() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/golden/polar.json");
    let golden: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let array = |v: &Value| v.as_array().unwrap().clone();
    let list = |v: &Value| -> Vec<f64> { array(v).iter().map(|v| v.as_f64().unwrap()).collect() };
    let point = |v: &Value| DVec2::from_slice(&list(v));
    let ring = |v: &Value| Footprint::new(array(v).iter().map(point).collect::<Vec<_>>());
    let index = |v: &Value| v.as_u64().unwrap() as usize;
    let city: Vec<Footprint> = array(&golden["city"]).iter().map(ring).collect();
    let scene = Scene::new(&city, None).unwrap();
    let fan = Fan {
        directions: index(&golden["directions"]),
        max_bounces: index(&golden["bounces"]),
    };
    let map = PolarMap::new(&scene, fan).unwrap();
    let mut count = 0;
    for link in array(&golden["links"]) {
        let points = [point(&link["tx"]), point(&link["rx"])];
        let (tx, rx) = prepare(&map, &points);
        let (transmitter, receiver) = (&tx[0], &rx[0]);
        let geodesic_m = PolarLink {
            map: &map,
            transmitter,
            receiver,
        }
        .geodesic_m()
        .unwrap();
        let expected_m = link["geodesic_m"].as_f64().unwrap();
        assert!(
            (geodesic_m - expected_m).abs() < 1e-8,
            "{geodesic_m} m instead of {expected_m} m"
        );
        let mut expected = Ways::new();
        for row in array(&link["rows"]) {
            for way in array(&row["ways"]) {
                let kind = index(&way[0]) * (fan.max_bounces + 1) + index(&way[1]);
                let key = [0, index(&row["direction"]), kind];
                let features = list(&way[2]).into_iter().map(|value| value as f32);
                assert!(expected.insert(key, features.collect()).is_none());
            }
        }
        // Of every other ray.
        let mut found = ways(&map, &points, Mirror::default());
        found.retain(|[_, direction, _], _| direction % 2 == 0);
        let [found_keys, expected_keys] =
            [&found, &expected].map(|ways| Vec::from_iter(ways.keys()));
        assert_eq!(found_keys, expected_keys, "{points:?}");
        for (key, expected) in &expected {
            for (i, (found, expected)) in found[key].iter().zip(expected).enumerate() {
                assert!(
                    (found - expected).abs() < 1e-5,
                    "{points:?}, {key:?}, feature {i}: {found} instead of {expected}"
                );
            }
        }
        count += expected.len();
    }
    assert!(count > 400, "{count}");
}

#[test]
fn ways_of_a_mirrored_map_are_the_mirrored_ways() {
    let footprints = city(256, 5).footprints().unwrap();
    let area = Some(Area::RADIOMAPSEER);
    let scene = Scene::new(&footprints, area).unwrap();
    let map = PolarMap::new(&scene, Fan::default()).unwrap();
    let points = off_grid(&scene, 24, 3);
    for mirror in Mirror::ALL {
        let turn = |p: DVec2| {
            let x = if mirror.x { SIDE_M - p.x } else { p.x };
            let y = if mirror.y { SIDE_M - p.y } else { p.y };
            DVec2::new(x, y)
        };
        let turned = Scene::new(&moved(&footprints, turn), area).unwrap();
        let turned = PolarMap::new(&turned, Fan::default()).unwrap();
        let ends: Vec<DVec2> = points.iter().map(|&p| turn(p)).collect();
        let expected = ways(&map, &points, mirror);
        let found = ways(&turned, &ends, Mirror::default());
        // Ways that tie may change places.
        let differ = differing(&expected, &found, 1e-3);
        assert!(
            differ <= expected.len() * FEATURES / 10_000,
            "{mirror:?}: {differ} of {} ways",
            expected.len()
        );
        let upright = ways(&map, &points, Mirror::default());
        let is_upright = mirror == Mirror::default();
        assert_eq!(differing(&expected, &upright, 1e-3) == 0, is_upright);
    }
}

#[test]
fn a_mirror_is_its_own_inverse_and_moves_rays_to_their_mirror_images() {
    let fan = Fan {
        directions: 12,
        max_bounces: 0,
    };
    for mirror in Mirror::ALL {
        for i in 0..12 {
            let from = mirror.direction(i, 12);
            assert_eq!(mirror.direction(from, 12), i);
            let sign = |is_mirrored: bool| if is_mirrored { -1.0 } else { 1.0 };
            let expected =
                DVec2::from_angle(fan.angle_rad(from)) * DVec2::new(sign(mirror.x), sign(mirror.y));
            assert!(DVec2::from_angle(fan.angle_rad(i)).distance(expected) < 1e-14);
        }
    }
}

#[test]
fn one_thread_and_four_make_the_same_bytes() {
    let scene = city_scene(256, 7);
    let points = outdoor_points(&scene, 12, 0);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let map = PolarMap::new(&scene, Fan::default()).unwrap();
            let ways = ways(&map, &points, Mirror::default()).into_iter();
            let bits = |way: Vec<f32>| way.into_iter().map(f32::to_bits).collect::<Vec<_>>();
            ways.map(|(key, way)| (key, bits(way))).collect::<Vec<_>>()
        })
    };
    assert!(with(1) == with(4));
}

#[test]
fn a_city_in_utm_coordinates_has_the_same_ways() {
    let footprints = city(256, 9).footprints().unwrap();
    let scene = Scene::new(&footprints, None).unwrap();
    let points = off_grid(&scene, 16, 1);
    let here = ways(
        &PolarMap::new(&scene, Fan::default()).unwrap(),
        &points,
        Mirror::default(),
    );
    for by in [
        DVec2::new(385_000.0, 6_671_000.0),
        DVec2::new(-8_000_001.0, 0.0),
    ] {
        let scene = Scene::new(&moved(&footprints, |p| p + by), None).unwrap();
        let points: Vec<DVec2> = points.iter().map(|&p| p + by).collect();
        let map = PolarMap::new(&scene, Fan::default()).unwrap();
        let there = ways(&map, &points, Mirror::default());
        assert_eq!(differing(&here, &there, 1e-5), 0, "{by}");
    }
}

/// Length of the shortest way between two points by relaxing all pairs of corners that see each other.
fn shortest_m(scene: &Scene, p: DVec2, q: DVec2) -> f64 {
    let corners = (0..scene.walls().len() as u32).filter(|&id| scene.is_convex(id));
    let mut places: Vec<DVec2> = corners.map(|id| scene.walls()[id as usize].a).collect();
    places.push(q);
    let step = |p: DVec2, q: DVec2| match scene.is_blocked(p, q) {
        true => f64::INFINITY,
        false => p.distance(q),
    };
    let steps: Vec<Vec<f64>> = places
        .iter()
        .map(|&p| places.iter().map(|&q| step(p, q)).collect())
        .collect();
    let mut lengths: Vec<f64> = places.iter().map(|&q| step(p, q)).collect();
    loop {
        let over = |to: usize| {
            let each = lengths
                .iter()
                .zip(&steps)
                .map(|(length, steps)| length + steps[to]);
            each.fold(lengths[to], f64::min)
        };
        let shorter: Vec<f64> = (0..places.len()).map(over).collect();
        if shorter == lengths {
            return lengths[places.len() - 1];
        }
        lengths = shorter;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    #[test]
    fn the_shortest_way_is_that_of_all_pairs_of_corners(seed in 0_u64..1000, offset in 0_u32..10_000, is_on_grid in any::<bool>()) {
        let scene = city_scene(200, seed);
        let points = if is_on_grid { outdoor_points(&scene, 8, offset) } else { off_grid(&scene, 8, offset) };
        let map = PolarMap::new(&scene, Fan { directions: 4, max_bounces: 0 }).unwrap();
        for pair in points.windows(2) {
            let [forth_m, back_m] = [[pair[0], pair[1]], [pair[1], pair[0]]].map(|points| {
                let (tx, rx) = prepare(&map, &points);
                PolarLink { map: &map, transmitter: &tx[0], receiver: &rx[0] }.geodesic_m().unwrap()
            });
            let expected_m = shortest_m(&scene, pair[0], pair[1]);
            let is_same = |m: f64| m == expected_m || (m - expected_m).abs() < 1e-9;
            prop_assert!(is_same(forth_m) && is_same(back_m), "{pair:?}: {forth_m} m, {back_m} m, not {expected_m} m");
        }
    }
}

/// A vertex on a grid so coarse that rings touch, cross and repeat each other often.
fn vertex() -> impl Strategy<Value = DVec2> {
    let coordinate = || prop_oneof![3 => (0..21).prop_map(f64::from), 1 => 0.0..20.0];
    (coordinate(), coordinate()).prop_map(DVec2::from)
}

/// Any closed walk, a needle, or a rectangle, with a courtyard or without.
fn footprint() -> impl Strategy<Value = Footprint> {
    let needle = (vertex(), vertex(), -12..0_i32).prop_map(|(a, b, exponent)| {
        vec![a, b, a.midpoint(b) + (b - a).perp() * 10_f64.powi(exponent)]
    });
    let box_of = |(a, b): (DVec2, DVec2)| {
        let (min, max) = (a.min(b), a.max(b));
        ring([min.x, max.x], [min.y, max.y])
    };
    let walk = prop::collection::vec(vertex(), 3..8);
    let outline = prop_oneof![walk, needle, (vertex(), vertex()).prop_map(box_of)];
    (outline, any::<bool>()).prop_map(move |(outer, has_yard)| {
        let (min, max) = outer.iter().fold((outer[0], outer[0]), |(min, max), &p| {
            (min.min(p), max.max(p))
        });
        let yard = box_of((min.lerp(max, 0.3), min.lerp(max, 0.6)));
        if has_yard {
            block(outer, yard)
        } else {
            Footprint::new(outer)
        }
    })
}

/// Places where a terminal may stand: anywhere, and at so small a distance from walls and their ends.
fn places(scene: &Scene, anywhere: &[DVec2], beside_m: f64) -> Vec<DVec2> {
    let beside = scene.walls().iter().flat_map(|wall| {
        let outward = wall.outward().normalize_or_zero() * beside_m;
        let before = scene.walls()[wall.previous as usize]
            .along()
            .normalize_or_zero();
        [
            wall.a.midpoint(wall.b) + outward,
            wall.a + outward,
            wall.a + before * beside_m,
            wall.b + outward,
        ]
    });
    let all = anywhere.iter().copied().chain(beside);
    all.filter(|&p| scene.check_terminal(p).is_ok())
        .take(12)
        .collect()
}

/// Checks the features of ways against the ranges they can have.
fn check(ways: &Ways) {
    for way in ways.values() {
        assert!(way.iter().all(|x| x.is_finite()), "{way:?}");
        assert!(
            way[1] == 1.0 && (0.0..=1.0).contains(&way[0]) && way[2].abs() <= 0.5,
            "{way:?}"
        );
        assert!((-0.1..=3.0).contains(&way[3]) && way[4] >= 0.0, "{way:?}");
        assert!(
            way[7] == 0.0 || [0.25, 0.5, 0.75, 1.0].contains(&way[7]),
            "{way:?}"
        );
        assert!(
            way[8] >= way[9] && way[9] >= 0.0 && way[10] >= 0.0,
            "{way:?}"
        );
        assert!(way[12].abs() < 1.001 && way[13].abs() < 1.001, "{way:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases.max(400)))]

    #[test]
    fn scenes_of_any_shape_give_finite_features(
        footprints in prop::collection::vec(footprint(), 0..6),
        anywhere in prop::collection::vec(vertex(), 2..6),
        exponent in -16..-1_i32,
        max_bounces in 0..4_usize,
        quarter in 1..5_usize,
    ) {
        let scene = Scene::new(&footprints, None);
        prop_assume!(scene.is_ok());
        let scene = scene.unwrap();
        let map = PolarMap::new(&scene, Fan { directions: 4 * quarter, max_bounces }).unwrap();
        let places = places(&scene, &anywhere, 10_f64.powi(exponent));
        // Each is a transmitter and a receiver, with itself as well.
        let points: Vec<DVec2> = places.iter().chain(&places).copied().collect();
        for mirror in Mirror::ALL {
            check(&ways(&map, &points, mirror));
        }
    }
}

#[test]
fn in_the_open_there_is_the_straight_way_alone() {
    let scene = Scene::new(&[], Some(Area::RADIOMAPSEER)).unwrap();
    let map = PolarMap::new(&scene, Fan::default()).unwrap();
    assert_eq!(map.corner_count(), 0);
    let rx = DVec2::new(100.0, 80.0);
    // A quarter of the way from ray 20 to ray 21.
    let angle_rad = map.fan().angle_rad(20) + 0.25 * map.fan().step_rad();
    let tx = rx + DVec2::from_angle(angle_rad) * 90.0;
    let found = ways(&map, &[tx, rx], Mirror::default());
    let step = map.fan().step_rad() as f32;
    let of_ray = |direction: usize| {
        let tangent = ((20.25 - direction as f32) * step).tan() / step;
        let mut features = vec![1.0 - tangent.abs(), 1.0, 0.5 * tangent];
        features.resize(FEATURES, 0.0);
        features[11] = 0.3 * 90.0_f32.ln() - 1.0;
        ([0, direction, 0], features)
    };
    let expected = Ways::from([20, 21].map(of_ray));
    assert_eq!(differing(&found, &expected, 1e-5), 0, "{found:?}");
}

#[test]
fn a_receiver_that_no_way_leads_to_has_no_ways() {
    let (outer, yard) = (
        ring([100.0, 150.0], [100.0, 150.0]),
        ring([110.0, 140.0], [110.0, 140.0]),
    );
    let scene = Scene::new(&[block(outer, yard)], Some(Area::RADIOMAPSEER)).unwrap();
    let map = PolarMap::new(&scene, Fan::default()).unwrap();
    let points = [DVec2::splat(50.0), DVec2::new(120.0, 130.0)];
    let (tx, rx) = prepare(&map, &points);
    let link = PolarLink {
        map: &map,
        transmitter: &tx[0],
        receiver: &rx[0],
    };
    assert_eq!(link.geodesic_m(), Ok(f64::INFINITY));
    assert!(ways(&map, &points, Mirror::default()).is_empty());
}

#[test]
fn terminals_stand_beside_walls_but_not_on_them() {
    let scene = Scene::from_radiomapseer("[[[40, 40], [60, 40], [60, 60], [40, 60]]]").unwrap();
    let map = PolarMap::new(&scene, Fan::default()).unwrap();
    for place in [
        (50.0, 50.0),
        (40.0, 50.0),
        (40.0, 40.0),
        (300.0, 0.0),
        (f64::NAN, 0.0),
    ] {
        let refused = |error| matches!(error, PolarError::Terminal(_));
        assert!(refused(map.transmitter(DVec2::from(place)).unwrap_err()));
        assert!(refused(map.receiver(DVec2::from(place)).unwrap_err()));
    }
    let beside = [
        (40_f64.next_down(), 50.0),
        (40_f64.next_down(), 40.0),
        (39.999, 39.999),
        (40.0, 40_f64.next_down()),
    ];
    let points: Vec<DVec2> = beside.into_iter().chain(beside).map(DVec2::from).collect();
    check(&ways(&map, &points, Mirror::default()));
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let house = "[[[40, 40], [60, 40], [60, 60], [40, 60]]]";
    let scene = Scene::from_radiomapseer(house).unwrap();
    let fan = |directions: usize, max_bounces: usize| Fan {
        directions,
        max_bounces,
    };
    for fan in [
        fan(0, 2),
        fan(181, 2),
        fan(182, 2),
        fan(usize::MAX - 3, 0),
        fan(4, usize::MAX),
        fan(180, 1 << 13),
    ] {
        let refused = matches!(PolarMap::new(&scene, fan), Err(PolarError::Fan { .. }));
        assert!(refused, "{fan:?}");
    }
    let map = PolarMap::new(&scene, Fan::default()).unwrap();
    assert_eq!(map.fan().way_kinds(), KINDS * 3);
    let (tx, rx) = (DVec2::ONE, DVec2::new(9.0, 4.0));
    let (transmitter, receiver) = (map.transmitter(tx).unwrap(), map.receiver(rx).unwrap());
    let link = PolarLink {
        map: &map,
        transmitter: &transmitter,
        receiver: &receiver,
    };
    let finer = PolarMap::new(&scene, fan(360, 2)).unwrap();
    let of_finer = finer.receiver(rx).unwrap();
    let mut found = Vec::new();
    let foreign = |terminal: &'static str| Err(PolarError::Foreign { terminal });
    // As many pieces, of other rays.
    let straight = PolarMap::new(&scene, fan(540, 0)).unwrap();
    for receiver in [&of_finer, &straight.receiver(rx).unwrap()] {
        let link = PolarLink { receiver, ..link };
        assert_eq!(link.ways(&mut found), foreign("receiver"));
    }
    let other = Scene::from_radiomapseer(
        "[[[80, 80], [90, 80], [85, 90]], [[40, 40], [60, 40], [60, 60], [40, 60]]]",
    )
    .unwrap();
    let other = PolarMap::new(&other, Fan::default()).unwrap();
    let (of_other, in_other) = (other.transmitter(tx).unwrap(), other.receiver(rx).unwrap());
    for (terminal, link) in [
        (
            "transmitter",
            PolarLink {
                transmitter: &of_other,
                ..link
            },
        ),
        (
            "receiver",
            PolarLink {
                receiver: &in_other,
                ..link
            },
        ),
    ] {
        assert_eq!(link.ways(&mut found), foreign(terminal));
        assert!(matches!(link.geodesic_m(), Err(PolarError::Foreign { .. })));
    }
    // Of another preparation of the same scene.
    let again = PolarMap::new(&scene, Fan::default()).unwrap();
    let receiver = &again.receiver(rx).unwrap();
    let of_again = PolarLink { receiver, ..link };
    assert_eq!(of_again.ways(&mut found), foreign("receiver"));
    assert!(found.is_empty());
    assert_eq!(link.ways(&mut found), Ok(()));
    assert!(!found.is_empty());
}
