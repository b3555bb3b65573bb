//! Exchanging transmitter and receiver: the same paths, walked backwards, with the same gain.
//!
//! Terminals are on the integer grid, as are the buildings, so that rays along walls and through
//! corners are common, and on a lattice of equal blocks they are the rule.

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Location;
use aps_raytrace::{Footprint, Link, Material, Scene, TraceConfig, Tracer};
use aps_tests::links::{by_sequence, outdoor_points, strongest, with_chains};
use aps_tests::maps::real_cities;
use aps_tests::shapes::{city_scene, points, rectangle, ring, scene};
use proptest::prelude::*;

/// Paths weaker than the strongest by more than this \[dB\] are sums that cancel: their gain is
/// rounding.
const CANCELLED_DB: f64 = 150.0;

fn small_city(seed: u64) -> Scene {
    city_scene(150, seed)
}

fn two_diffractions() -> TraceConfig {
    TraceConfig {
        max_reflections: 1,
        max_diffractions: 2,
        slope_diffraction: false,
        ..with_chains()
    }
}

fn with_slopes() -> TraceConfig {
    TraceConfig {
        slope_diffraction: true,
        ..two_diffractions()
    }
}

fn everything() -> TraceConfig {
    TraceConfig {
        dynamic_range_db: None,
        ..TraceConfig::default()
    }
}

/// Counts and largest difference of a comparison of links both ways.
#[derive(Default)]
struct Tally {
    links: usize,
    paths: usize,
    fallbacks: usize,
    /// Largest difference of gains, relative.
    worst: f64,
}

impl Tally {
    fn compare(&mut self, forth: &Link, back: &Link, what: &str) {
        let (p, q) = (
            by_sequence(&forth.paths, false),
            by_sequence(&back.paths, true),
        );
        assert!(
            p.keys().eq(q.keys()),
            "{what}: forth {:?}, back {:?}",
            p.keys().filter(|k| !q.contains_key(*k)).collect::<Vec<_>>(),
            q.keys().filter(|k| !p.contains_key(*k)).collect::<Vec<_>>(),
        );
        assert_eq!(
            forth.fallback_diffractions, back.fallback_diffractions,
            "{what}"
        );
        let floor = strongest(&forth.paths) * 10_f64.powf(-CANCELLED_DB / 10.0);
        for (path, twin) in p.values().zip(q.values()) {
            let error = (path.gain - twin.gain).norm() / path.gain.norm();
            assert!(error < 1e-9 || path.power() < floor, "{what}: {error:e}");
            if path.power() >= floor {
                self.worst = self.worst.max(error);
            }
            assert!((path.length_m - twin.length_m).abs() <= 1e-12 * path.length_m);
            let ends = [path.departure_azimuth_rad, path.arrival_azimuth_rad];
            let back = [twin.arrival_azimuth_rad, twin.departure_azimuth_rad];
            assert_eq!(ends, back, "{what}");
        }
        self.links += 1;
        self.paths += p.len();
        self.fallbacks += usize::from(forth.fallback_diffractions.is_some());
    }

    /// Compares all links between two sets of terminals both ways.
    fn check(&mut self, scene: &Scene, config: &TraceConfig, ends: [&[DVec2]; 2]) {
        let tracer = Tracer::new(scene, config.clone()).unwrap();
        let [near, far] = ends.map(|points| {
            points
                .iter()
                .map(|&p| (tracer.transmitter(p).unwrap(), tracer.receiver(p).unwrap()))
                .collect::<Vec<_>>()
        });
        let (mut forth, mut back) = (Link::default(), Link::default());
        for (tx, tx_as_rx) in &near {
            for (rx_as_tx, rx) in &far {
                tracer.link(tx, rx, &mut forth).unwrap();
                tracer.link(rx_as_tx, tx_as_rx, &mut back).unwrap();
                let what = format!("{} -> {}", tx.position(), rx.position());
                self.compare(&forth, &back, &what);
            }
        }
    }

    fn print(&self, what: &str) {
        eprintln!(
            "{what}: {} links, {} paths, {} links by fallback; gains differ by {:.1e} at most",
            self.links, self.paths, self.fallbacks, self.worst
        );
    }
}

/// Outdoor points of a scene, cut in two sets.
fn check_city(tally: &mut Tally, scene: &Scene, config: &TraceConfig, counts: [usize; 2]) {
    let points = outdoor_points(scene, counts[0] + counts[1], 0);
    let (near, far) = points.split_at(counts[0]);
    tally.check(scene, config, [near, far]);
}

#[test]
fn synthetic_cities_at_default_limits() {
    let mut tally = Tally::default();
    for seed in 1..=6 {
        check_city(&mut tally, &small_city(seed), &with_chains(), [15, 60]);
        check_city(&mut tally, &small_city(seed), &everything(), [10, 40]);
    }
    tally.print("cities, R <= 2, D <= 1");
    assert!(tally.paths > 10_000 && tally.fallbacks > 100);
}

#[test]
fn synthetic_cities_with_two_diffractions() {
    let mut tally = Tally::default();
    for seed in 1..=3 {
        check_city(&mut tally, &small_city(seed), &two_diffractions(), [6, 20]);
    }
    tally.print("cities, R <= 1, D <= 2");
    assert!(tally.paths > 1_000);
}

#[test]
fn real_cities_at_default_limits() {
    for (name, scene) in real_cities(&[0, 21, 48]) {
        let mut tally = Tally::default();
        check_city(&mut tally, &scene, &with_chains(), [10, 50]);
        tally.print(&format!("{name}, R <= 2, D <= 1"));
        assert!(tally.paths > 2_000 && tally.fallbacks > 10);
    }
}

#[test]
fn real_cities_with_two_diffractions() {
    for (name, scene) in real_cities(&[0]) {
        let mut tally = Tally::default();
        check_city(&mut tally, &scene, &two_diffractions(), [4, 20]);
        tally.print(&format!("{name}, R <= 1, D <= 2"));
        assert!(tally.paths > 1_000);
    }
}

/// Equal blocks in rows: nearly every ray that meets one corner meets a second, and chains of
/// corners come in mirror images of exactly equal strength.
#[test]
fn lattices_of_equal_blocks() {
    let square = [(0, 0), (10, 0), (10, 10), (0, 10)];
    let diamond = [(0, 5), (5, 0), (10, 5), (5, 10)];
    for (name, odd) in [("squares", square), ("squares and diamonds", diamond)] {
        let blocks: Vec<Footprint> = (0..16)
            .map(|i| {
                let (x, y) = (20 * (i % 4), 20 * (i / 4));
                let shape = if (i % 4 + i / 4) % 2 == 0 {
                    square
                } else {
                    odd
                };
                Footprint::new(shape.map(|(u, v)| DVec2::new((x + u).into(), (y + v).into())))
            })
            .collect();
        let scene = scene(&blocks);
        let points: Vec<DVec2> = (0..400)
            .map(|i| DVec2::new((5 * (i * 7 % 20) - 10).into(), (5 * (i / 20) - 10).into()))
            .filter(|&p| scene.locate(p) == Location::Outdoor)
            .step_by(3)
            .collect();
        let (near, far) = points.split_at(points.len() / 2);
        let nothing = TraceConfig {
            max_reflections: 0,
            max_diffractions: 0,
            ..with_chains()
        };
        let configs = [
            (with_chains(), 1),
            (everything(), 2),
            (nothing, 1),
            (two_diffractions(), 4),
            (with_slopes(), 4),
        ];
        for (config, every) in configs {
            let mut tally = Tally::default();
            let far: Vec<DVec2> = far.iter().copied().step_by(every).collect();
            let near: Vec<DVec2> = near.iter().copied().step_by(every).collect();
            tally.check(&scene, &config, [&near, &far]);
            tally.print(&format!(
                "{name}, R <= {}, D <= {}",
                config.max_reflections, config.max_diffractions
            ));
            assert!(tally.links > 100);
        }
    }
}

/// A scene that a half turn maps onto itself, and ends that it exchanges: a chain and its image
/// walked backwards are equally strong. Both directions must choose the same one of the two.
#[test]
fn chains_of_equal_strength_are_chosen_alike() {
    let mut state = 7_u32;
    let mut below = |limit: i32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as i32 % limit
    };
    let mut tally = Tally::default();
    let config = TraceConfig {
        max_reflections: 0,
        max_diffractions: 0,
        ..with_chains()
    };
    for _ in 0..6 {
        let mut boxes: Vec<[i32; 4]> = Vec::new();
        while boxes.len() < 60 {
            let (w, h) = (2 + below(24), 2 + below(4));
            let (w, h) = if below(2) == 0 { (w, h) } else { (h, w) };
            let (x, y) = (below(90) - 45, below(45));
            let (one, other) = ([x, y, x + w, y + h], [-x - w, -y - h, -x, -y]);
            let apart = |p: &[i32; 4], q: &[i32; 4]| {
                p[0] > q[2] + 1 || q[0] > p[2] + 1 || p[1] > q[3] + 1 || q[1] > p[3] + 1
            };
            let is_free = |q: &[i32; 4]| boxes.iter().all(|p| apart(p, q));
            if apart(&one, &other) && is_free(&one) && is_free(&other) {
                boxes.extend([one, other]);
            } else if below(400) == 0 {
                break;
            }
        }
        let house = |corners: &[i32; 4]| {
            let [x0, y0, x1, y1] = corners.map(f64::from);
            rectangle(x0, y0, x1, y1)
        };
        let scene = scene(&boxes.iter().map(house).collect::<Vec<_>>());
        let tracer = Tracer::new(&scene, config.clone()).unwrap();
        for _ in 0..40 {
            let p = DVec2::new((below(90) - 45).into(), (below(90) - 45).into());
            if p == DVec2::ZERO || scene.locate(p) != Location::Outdoor {
                continue;
            }
            let (forth, back) = (tracer.trace(p, -p).unwrap(), tracer.trace(-p, p).unwrap());
            tally.compare(&forth, &back, &format!("{p} -> {}", -p));
        }
    }
    tally.print("half turn, chains only");
    assert!(tally.fallbacks > 100);
}

/// Millimetres from the corners of turned houses, images lie next to the tips of windows: no wave goes from one outer face of
/// a corner to the other, whichever end is asked.
#[test]
fn terminals_at_the_corners_of_turned_houses() {
    let mut tally = Tally::default();
    for i in 0..300 {
        let turned = |p: DVec2| DVec2::from_angle(0.3 + 0.37 * f64::from(i)).rotate(p);
        let house = ring([0.0, 20.0], [0.0, 20.0]).into_iter().map(turned);
        let house: Vec<DVec2> = house.collect();
        let scene = scene(&[Footprint::new(house.clone())]);
        let is_outdoor = |p: &DVec2| scene.locate(*p) == Location::Outdoor;
        let around = |n: usize, distance: f64| {
            let angle = f64::from(17 * i) + 2.4 * n as f64;
            house[n % 4] + DVec2::from_angle(angle) * distance
        };
        let near = (0..24).map(|n| around(n, 1.5e-3 * (1 + n / 4) as f64));
        let far = (0..24).map(|n| around(n, 60.0));
        let [near, far]: [Vec<DVec2>; 2] = [
            near.filter(is_outdoor).collect(),
            far.filter(is_outdoor).collect(),
        ];
        tally.check(&scene, &with_chains(), [&near, &far]);
    }
    // A triangle whose first corner the first terminal is next to.
    let triangle =
        points("37,7 18.221724974492243,0.11694929072931615 43.88305070927068,-11.77827502550776");
    let near = DVec2::new(37.00118068094506, 7.001049610995466);
    let far = DVec2::new(88.70841580387524, 52.960338871687895);
    tally.check(
        &scene(&[Footprint::new(triangle)]),
        &with_chains(),
        [&[near], &[far]],
    );
    tally.print("next to corners, R <= 2, D <= 1");
    assert!(tally.links > 50_000);
}

/// A wave around a corner on one side does not leave on the other side where houses touch at corners.
#[test]
fn houses_that_touch_at_corners() {
    let mut state = 5_u32;
    let mut below = |limit: i32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as i32 % limit
    };
    let straight = TraceConfig {
        max_reflections: 0,
        ..two_diffractions()
    };
    let mut tally = Tally::default();
    for _ in 0..60 {
        let mut corner = || DVec2::new((8 * below(4)).into(), (8 * below(4)).into());
        let triangles = (0..6).map(|_| [corner(), corner(), corner()]);
        let triangles = triangles.filter(|&[a, b, c]| (b - a).perp_dot(c - a) != 0.0);
        let houses: Vec<Footprint> = triangles.map(Footprint::new).collect();
        let scene = scene(&houses);
        let points: Vec<DVec2> = (0..64)
            .map(|i| DVec2::new((6 * (i % 8) - 9).into(), (6 * (i / 8) - 9).into()))
            .filter(|&p| scene.locate(p) == Location::Outdoor)
            .step_by(3)
            .collect();
        let (near, far) = points.split_at(points.len() / 2);
        for config in [&straight, &two_diffractions()] {
            tally.check(&scene, config, [near, far]);
        }
    }
    tally.print("touching houses, R <= 1, D <= 2");
    assert!(tally.links > 3_000);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any city, any material, any limits, terminals off the grid too.
    #[test]
    fn any_city_any_limits(
        seed in 0_u64..1_000_000,
        reflections in 0_usize..=3,
        diffractions in 0_usize..=2,
        slope_diffraction in any::<bool>(),
        eps in 1.0_f64..20.0,
        grain in prop::sample::select(vec![1.0, 0.5, 0.37]),
        offset in 0_u32..100_000,
    ) {
        let scene = small_city(seed);
        let config = TraceConfig {
            material: Material::Dielectric {
                relative_permittivity: eps,
                conductivity_s_per_m: 0.01,
            },
            max_reflections: reflections.min(3 - diffractions),
            max_diffractions: diffractions,
            max_interactions: 3,
            slope_diffraction,
            ..with_chains()
        };
        let points: Vec<DVec2> = outdoor_points(&scene, 60, offset)
            .into_iter()
            .map(|p| p * grain)
            .filter(|&p| scene.locate(p) == Location::Outdoor)
            .take(16)
            .collect();
        let (near, far) = points.split_at(points.len() / 3);
        Tally::default().check(&scene, &config, [near, far]);
    }
}
