//! Rays of receivers and planes of links: against exhaustive search, a script of another hand, and mirror images.

use aps_raytrace::fields::{
    Fan, Field, FieldConfig, FieldError, FieldGrid, FieldLink, FieldMap, Mirror, NUMBERS, PLANES,
    ReceiverRays, TransmitterFields, gather,
};
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Location;
use aps_raytrace::{Area, Footprint, Scene};
use aps_tests::links::outdoor_points;
use aps_tests::shapes::{city, city_scene, moved};
use proptest::prelude::*;
use serde_json::Value;

const SIDE_M: f64 = 256.0;

fn off_grid(scene: &Scene, count: usize, offset: u32) -> Vec<DVec2> {
    // A ray from whole metres may run through a corner.
    let points = outdoor_points(scene, 2 * count, offset).into_iter();
    let moved = points.map(|p| p + DVec2::new(0.317, 0.441));
    let outdoor = moved.filter(|&p| scene.locate(p) == Location::Outdoor);
    outdoor.take(count).collect()
}

/// The place on a ray at an unfolded range by every wall in turn, with the bounces before it; `None` beyond so many.
fn follow(
    scene: &Scene,
    from: DVec2,
    angle_rad: f64,
    range_m: f64,
    bounces: usize,
) -> Option<(DVec2, usize)> {
    let (mut p, mut u, mut left_m) = (from, DVec2::from_angle(angle_rad), range_m);
    let mut last = None;
    for bounce in 0..=bounces {
        let hits = scene.walls().iter().enumerate().filter_map(|(id, wall)| {
            let (d, r) = (wall.b - wall.a, wall.a - p);
            let denominator = u.perp_dot(d);
            let (t, s) = (r.perp_dot(d) / denominator, r.perp_dot(u) / denominator);
            let is_hit = Some(id) != last && t > 1e-9 && (0.0..=1.0).contains(&s);
            is_hit.then_some((t, id))
        });
        let first = hits.min_by(|p, q| p.0.total_cmp(&q.0));
        match first {
            Some((t, id)) if t <= left_m => {
                let along = (scene.walls()[id].b - scene.walls()[id].a).normalize();
                p += u * t;
                u = along * (2.0 * u.dot(along)) - u;
                left_m -= t;
                last = Some(id);
            }
            _ => return Some((p + u * left_m, bounce)),
        }
    }
    None
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, ..ProptestConfig::default() })]

    #[test]
    fn rays_are_at_the_places_that_all_walls_in_turn_lead_to(
        seed in 0_u64..1000,
        offset in 0_u32..10_000,
        max_bounces in 0_usize..5,
    ) {
        let scene = city_scene(256, seed);
        let fan = Fan { directions: 60, ranges_m: Fan::log_spaced(12, 1.0, 320.0), max_bounces };
        let config = FieldConfig { fan, ..FieldConfig::default() };
        let map = FieldMap::new(&scene, config).unwrap();
        let rx = off_grid(&scene, 1, offset)[0];
        let rays = map.receiver(rx).unwrap();
        for direction in 0..60 {
            for range in 0..12 {
                let range_m = map.fan().ranges_m[range];
                let angle_rad = map.fan().angle_rad(direction);
                let expected = follow(&scene, rx, angle_rad, range_m, max_bounces);
                let found = rays.sample(&map, range, direction);
                prop_assert_eq!(found.is_some(), expected.is_some());
                let (Some(found), Some((place, bounces))) = (found, expected) else { continue };
                prop_assert!(found.position.distance(place) < 1e-4);
                prop_assert_eq!(found.bounces, bounces);
                prop_assert_eq!(found.is_outside, map.grid().pixel_at(place).is_none());
                prop_assert_eq!(found.range_m, range_m);
            }
        }
    }
}

/// Planes and numbers of all links of the transmitters with the receivers.
fn all_links(
    map: &FieldMap<'_>,
    tx: &[TransmitterFields],
    rx: &[ReceiverRays],
    mirror: Mirror,
) -> [Vec<f32>; 2] {
    let pairs = tx.iter().flat_map(|tx| rx.iter().map(move |rx| (tx, rx)));
    let links: Vec<FieldLink<'_>> = pairs
        .map(|(transmitter, receiver)| FieldLink {
            map,
            transmitter,
            receiver,
            mirror,
        })
        .collect();
    let mut planes = vec![f32::NAN; links.len() * PLANES * map.fan().positions()];
    let mut numbers = vec![f32::NAN; links.len() * NUMBERS * map.fan().directions];
    gather(&links, &mut planes, &mut numbers).unwrap();
    [planes, numbers]
}

fn prepare(map: &FieldMap<'_>, points: &[DVec2]) -> (Vec<TransmitterFields>, Vec<ReceiverRays>) {
    let (tx, rx) = points.split_at(points.len() / 2);
    (
        tx.iter().map(|&p| map.transmitter(p).unwrap()).collect(),
        rx.iter().map(|&p| map.receiver(p).unwrap()).collect(),
    )
}

#[test]
fn fields_of_a_mirrored_map_are_the_mirrored_fields() {
    let footprints = city(256, 5).footprints().unwrap();
    let area = Some(Area::RADIOMAPSEER);
    let scene = Scene::new(&footprints, area).unwrap();
    let map = FieldMap::new(&scene, FieldConfig::default()).unwrap();
    let points = off_grid(&scene, 12, 3);
    let (tx, rx) = prepare(&map, &points);
    for mirror in Mirror::ALL {
        let turn = |p: DVec2| {
            let x = if mirror.x { SIDE_M - p.x } else { p.x };
            let y = if mirror.y { SIDE_M - p.y } else { p.y };
            DVec2::new(x, y)
        };
        let turned = moved(&footprints, turn);
        let turned = Scene::new(&turned, area).unwrap();
        let turned = FieldMap::new(&turned, FieldConfig::default()).unwrap();
        let ends: Vec<DVec2> = points.iter().map(|&p| turn(p)).collect();
        let (turned_tx, turned_rx) = prepare(&turned, &ends);

        let (width, height) = (map.grid().width, map.grid().height);
        for (upright, turned_tx) in tx.iter().zip(&turned_tx) {
            for field in Field::ALL {
                let upright = upright.lengths_m(&map, field);
                let found = turned_tx.lengths_m(&turned, field);
                for (pixel, found) in found.into_iter().enumerate() {
                    let from = mirror.pixel(pixel, width, height);
                    let expected = upright[from];
                    // A pixel on one line with two corners is either one's, and a neighbour indoors is so too.
                    let tolerance = if map.is_outdoor()[from] { 2e-4 } else { 0.5 };
                    assert!(
                        found == expected || (found - expected).abs() < tolerance,
                        "{mirror:?} {field:?} at {pixel}: {found} m instead of {expected} m"
                    );
                }
            }
        }
        let expected = all_links(&map, &tx, &rx, mirror);
        let found = all_links(&turned, &turned_tx, &turned_rx, Mirror::default());
        let pairs = expected.iter().flatten().zip(found.iter().flatten());
        let differ = pairs.filter(|(p, q)| (*p - *q).abs() > 1e-3).count();
        let all = expected.iter().flatten().count();
        assert!(differ < all / 20_000, "{mirror:?}: {differ} of {all}");
    }
}

#[test]
fn a_detour_is_nothing_where_the_transmitter_is_in_sight_along_the_ray() {
    let scene = Scene::new(&[], Some(Area::RADIOMAPSEER)).unwrap();
    let map = FieldMap::new(&scene, FieldConfig::default()).unwrap();
    let rx = DVec2::new(100.0, 80.0);
    let angle_rad = map.fan().angle_rad(20);
    let tx = map
        .transmitter(rx + DVec2::from_angle(angle_rad) * 90.0)
        .unwrap();
    let [planes, numbers] = all_links(&map, &[tx], &[map.receiver(rx).unwrap()], Mirror::default());
    let n = map.fan().directions;
    for (range, range_m) in map.fan().ranges_m.iter().enumerate() {
        let detour_m = 2.0 * (range_m - 90.0).max(0.0);
        let found = planes[4 * map.fan().positions() + range * n + 20];
        let is_outside = range_m * angle_rad.cos() > 156.0 || range_m * angle_rad.sin() > 176.0;
        let expected = if is_outside {
            0.0
        } else {
            (-detour_m / 2.0).exp()
        };
        assert!(
            (f64::from(found) - expected).abs() < 1e-4,
            "{range_m} m: {found} {expected}"
        );
    }
    assert!((numbers[20] - 1.0).abs() < 1e-6 && numbers[n + 20].abs() < 1e-6);
    let log = (90.0_f64.ln() / 3.0 - 1.0) as f32;
    assert!((numbers[2 * n] - log).abs() < 1e-6 && (numbers[3 * n] - log).abs() < 1e-6);
}

#[test]
fn one_thread_and_four_make_the_same_bytes() {
    let scene = city_scene(256, 7);
    let points = outdoor_points(&scene, 12, 0);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let map = FieldMap::new(&scene, FieldConfig::default()).unwrap();
            let (tx, rx) = prepare(&map, &points);
            let [planes, numbers] = all_links(&map, &tx, &rx, Mirror::default());
            let lengths = tx.iter().flat_map(|tx| tx.lengths_m(&map, Field::Twice));
            let all = planes.into_iter().chain(numbers).chain(lengths);
            all.map(f32::to_bits).collect::<Vec<_>>()
        })
    };
    assert!(with(1) == with(4));
}

#[test]
fn a_receiver_that_no_way_leads_to_has_no_detours() {
    let square = |lo: f64, hi: f64| [(lo, lo), (hi, lo), (hi, hi), (lo, hi)].map(DVec2::from);
    let mut block = Footprint::new(square(100.0, 150.0));
    block.holes.push(square(110.0, 140.0).into());
    let scene = Scene::new(&[block], Some(Area::RADIOMAPSEER)).unwrap();
    let map = FieldMap::new(&scene, FieldConfig::default()).unwrap();
    let tx = map.transmitter(DVec2::new(50.0, 50.0)).unwrap();
    let rx = map.receiver(DVec2::new(120.0, 130.0)).unwrap();
    let [planes, numbers] = all_links(&map, &[tx], &[rx], Mirror::default());
    let positions = map.fan().positions();
    assert!(
        planes[3 * positions..10 * positions]
            .iter()
            .all(|&v| v < 1e-30)
    );
    assert!(planes.iter().chain(&numbers).all(|v| v.is_finite()));
    let log = (1200.0_f64.ln() / 3.0 - 1.0) as f32;
    assert_eq!(numbers[3 * map.fan().directions], log);
}

#[test]
fn every_number_is_that_of_the_script() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/golden/fields.json");
    let golden: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let list = |v: &Value| -> Vec<f64> {
        let all = v.as_array().unwrap().iter();
        all.map(|v| v.as_f64().unwrap_or(f64::INFINITY)).collect()
    };
    let point = |v: &Value| DVec2::from_slice(&list(v));
    let ring =
        |v: &Value| Footprint::new(v.as_array().unwrap().iter().map(point).collect::<Vec<_>>());
    let city: Vec<Footprint> = golden["city"]
        .as_array()
        .unwrap()
        .iter()
        .map(ring)
        .collect();
    let side = golden["side"].as_f64().unwrap();
    let area = Area {
        min: DVec2::ZERO,
        max: DVec2::splat(side),
    };
    let scene = Scene::new(&city, Some(area)).unwrap();
    let config = FieldConfig {
        grid: FieldGrid::over(area, 1.0),
        fan: Fan {
            directions: golden["directions"].as_u64().unwrap() as usize,
            ranges_m: list(&golden["ranges_m"]),
            max_bounces: 3,
        },
    };
    let map = FieldMap::new(&scene, config).unwrap();
    let tx = map.transmitter(point(&golden["tx"])).unwrap();
    let check = |name: &str, found: Vec<f64>, expected: &Value, tolerance: f64| {
        let expected = list(expected);
        assert_eq!(found.len(), expected.len());
        for (i, (found, expected)) in found.into_iter().zip(expected).enumerate() {
            let is_equal = found == expected || (found - expected).abs() < tolerance;
            assert!(
                is_equal,
                "{name}, number {i}: {found} instead of {expected}"
            );
        }
    };
    let wide = |v: Vec<f32>| v.into_iter().map(f64::from).collect::<Vec<_>>();
    let in_sight = tx.in_sight().into_iter().map(f64::from).collect();
    check("in sight", in_sight, &golden["in_sight"], 0.5);
    let names = ["geodesic_m", "once_m", "twice_m"];
    for (field, name) in Field::ALL.into_iter().zip(names) {
        check(name, wide(tx.lengths_m(&map, field)), &golden[name], 2e-5);
    }
    for link in golden["links"].as_array().unwrap() {
        let rx = map.receiver(point(&link["rx"])).unwrap();
        let [planes, numbers] =
            all_links(&map, std::slice::from_ref(&tx), &[rx], Mirror::default());
        check("planes", wide(planes), &link["planes"], 2e-5);
        check("numbers", wide(numbers), &link["numbers"], 2e-6);
    }
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let scene = Scene::from_radiomapseer("[[[40, 40], [60, 40], [60, 60], [40, 60]]]").unwrap();
    let with_grid = |grid: FieldGrid| {
        let config = FieldConfig {
            grid,
            ..FieldConfig::default()
        };
        FieldMap::new(&scene, config).unwrap_err()
    };
    let grid = FieldGrid::default();
    let far = DVec2::new(1e12, 0.0);
    for grid in [
        FieldGrid { width: 0, ..grid },
        FieldGrid { height: 0, ..grid },
        FieldGrid {
            width: usize::MAX,
            ..grid
        },
        FieldGrid {
            pixel_m: 0.0,
            ..grid
        },
        FieldGrid {
            pixel_m: f64::NAN,
            ..grid
        },
        FieldGrid {
            first_m: far,
            ..grid
        },
        FieldGrid {
            first_m: DVec2::NAN,
            ..grid
        },
        FieldGrid::over(Area::RADIOMAPSEER, 1e-9),
        FieldGrid::over(Area::RADIOMAPSEER, 0.0),
        FieldGrid::over(Area::RADIOMAPSEER, -1.0),
    ] {
        assert!(
            matches!(with_grid(grid), FieldError::Grid { .. }),
            "{grid:?}"
        );
    }
    let with_fan = |fan: Fan| {
        let config = FieldConfig {
            fan,
            ..FieldConfig::default()
        };
        FieldMap::new(&scene, config).unwrap_err()
    };
    let ranges = |ranges_m: &[f64]| Fan {
        ranges_m: ranges_m.to_vec(),
        ..Fan::default()
    };
    let directions = |directions: usize| Fan {
        directions,
        ..Fan::default()
    };
    let bounces = Fan {
        max_bounces: 1000,
        ..Fan::default()
    };
    for fan in [
        ranges(&[]),
        ranges(&[2.0, 1.0]),
        ranges(&[0.0, 1.0]),
        ranges(&[1.0, f64::INFINITY]),
        directions(0),
        directions(181),
        directions(usize::MAX - 3),
        bounces,
    ] {
        assert!(matches!(with_fan(fan), FieldError::Fan { .. }));
    }

    let map = FieldMap::new(&scene, FieldConfig::default()).unwrap();
    for place in [(50.0, 50.0), (40.0, 50.0), (300.0, 0.0), (f64::NAN, 0.0)] {
        let refused = |error| matches!(error, FieldError::Terminal(_));
        assert!(refused(map.transmitter(DVec2::from(place)).unwrap_err()));
        assert!(refused(map.receiver(DVec2::from(place)).unwrap_err()));
    }

    let transmitter = map.transmitter(DVec2::ONE).unwrap();
    let receiver = map.receiver(DVec2::new(9.0, 4.0)).unwrap();
    let link = FieldLink {
        map: &map,
        transmitter: &transmitter,
        receiver: &receiver,
        mirror: Mirror::default(),
    };
    let (planes, numbers) = (
        PLANES * map.fan().positions(),
        NUMBERS * map.fan().directions,
    );
    let error = gather(&[link], &mut vec![0.0; planes - 1], &mut vec![0.0; numbers]).unwrap_err();
    assert!(matches!(error, FieldError::Length { what: "planes", .. }));
    let error = gather(&[link], &mut vec![0.0; planes], &mut []).unwrap_err();
    assert!(matches!(
        error,
        FieldError::Length {
            what: "numbers",
            ..
        }
    ));
    assert_eq!(gather(&[], &mut [], &mut []), Ok(()));

    let config = FieldConfig {
        grid: FieldGrid::over(Area::RADIOMAPSEER, 2.0),
        fan: ranges(&[1.0, 2.0]),
    };
    let other = FieldMap::new(&scene, config).unwrap();
    let transmitter = other.transmitter(DVec2::ONE).unwrap();
    let mixed = FieldLink {
        map: &other,
        ..link
    };
    let error = gather(&[link, mixed], &mut [], &mut []).unwrap_err();
    assert_eq!(error, FieldError::MixedFans { link: 1 });
    let foreign = FieldLink {
        transmitter: &transmitter,
        ..link
    };
    let error = gather(&[foreign], &mut vec![0.0; planes], &mut vec![0.0; numbers]).unwrap_err();
    assert_eq!(
        error,
        FieldError::Foreign {
            terminal: "transmitter"
        }
    );
}
