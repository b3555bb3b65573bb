//! A dynamic range leaves the paths that are left of all paths when the weak ones are cut off: the same bits in the same order,
//! whatever the search did not look at.

use std::collections::BTreeMap;
use std::sync::{Mutex, OnceLock};

use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{CityConfig, Footprint, Location};
use aps_raytrace::{Area, Link, PathRecord, Scene, TraceConfig, Tracer};
use aps_tests::links::{strongest, with_chains};
use aps_tests::maps::real_cities;
use proptest::prelude::*;
use proptest::sample::select;

/// Reflections and diffractions.
const LIMITS: [(usize, usize); 7] = [(0, 1), (3, 1), (0, 2), (1, 2), (2, 2), (4, 2), (1, 3)];

/// Scenes with terminals in them, made when first asked for.
fn places() -> &'static [(String, Scene, Vec<DVec2>)] {
    static PLACES: OnceLock<Vec<(String, Scene, Vec<DVec2>)>> = OnceLock::new();
    PLACES.get_or_init(|| {
        let mut scenes = Vec::new();
        for (seed, street_m) in [(1, 12), (2, 20), (3, 6)] {
            let city = CityConfig {
                size_m: 100,
                block_m: 24,
                street_m,
                seed,
            };
            scenes.push((format!("city {seed}"), Scene::synthetic(&city).unwrap()));
        }
        scenes.push(("a corner on a wall".into(), touching()));
        scenes.extend(real_cities(&[38, 0]));
        let with_terminals = |(name, scene): (String, Scene)| {
            let points = outdoors(&scene);
            (name, scene, points)
        };
        scenes.into_iter().map(with_terminals).collect()
    })
}

/// Houses of which a corner lies on a wall up to rounding: a leg there takes no slope along, beside others that do.
fn touching() -> Scene {
    let large = [
        [22.335973287879142, 7.975230233864687],
        [37.332603307379564, 8.293173716607672],
        [37.01465982463658, 23.289803736108095],
        [22.01802980513616, 22.97186025336511],
    ];
    let small = [
        [37.067650405093744, 20.790365399524692],
        [42.06652707826055, 20.89634656043902],
        [41.8545647564319, 30.894099906772635],
        [36.85568808326509, 30.788118745858306],
    ];
    let houses = [large, small].map(|points| Footprint::new(points.map(DVec2::from_array)));
    let area = Area {
        min: DVec2::ZERO,
        max: DVec2::new(70.0, 45.0),
    };
    Scene::new(&houses, Some(area)).unwrap()
}

/// Points on whole and half metres of the scene's area, in a scattered order.
fn outdoors(scene: &Scene) -> Vec<DVec2> {
    let Area { min, max } = scene.area().unwrap();
    let size = (max - min) * 2.0;
    (0..)
        .map(|i: u32| {
            let j = i.wrapping_mul(2_654_435_761) >> 8;
            let at = |cells: f64, j: u32| f64::from(j % (cells as u32)) / 2.0;
            min + DVec2::new(at(size.x, j), at(size.y, j / (size.x as u32)))
        })
        .filter(|&p| scene.locate(p) == Location::Outdoor)
        .take(40)
        .collect()
}

fn config(
    (max_reflections, max_diffractions): (usize, usize),
    sum: usize,
    slope_diffraction: bool,
) -> TraceConfig {
    TraceConfig {
        max_reflections,
        max_diffractions,
        max_interactions: sum,
        slope_diffraction,
        dynamic_range_db: None,
        ..with_chains()
    }
}

/// Tracers by place, limits and range: most of the time goes into maps.
fn traced(place: usize, config: &TraceConfig, ends: [DVec2; 2]) -> Link {
    type Tracers = BTreeMap<String, Tracer<'static>>;
    static TRACERS: Mutex<Tracers> = Mutex::new(Tracers::new());
    let mut tracers = TRACERS.lock().unwrap_or_else(|e| e.into_inner());
    let key = format!("{place} {config:?}");
    let scene = &places()[place].1;
    let tracer = tracers
        .entry(key)
        .or_insert_with(|| Tracer::new(scene, config.clone()).unwrap());
    tracer.trace(ends[0], ends[1]).unwrap()
}

/// Every number and interaction of a path, to be compared bit by bit.
fn bits(path: &PathRecord) -> (String, [u64; 6]) {
    let numbers = [
        path.length_m,
        path.delay_s,
        path.departure_azimuth_rad,
        path.arrival_azimuth_rad,
        path.gain.re,
        path.gain.im,
    ];
    let interactions = format!("{:?}", path.interactions);
    (interactions, numbers.map(f64::to_bits))
}

fn check(all: &Link, cut: &Link, range_db: f64) {
    let ratio = 10.0_f64.powf(-range_db / 20.0);
    let floor = strongest(&all.paths) * ratio * ratio;
    let (kept, left_out): (Vec<_>, Vec<_>) = all.paths.iter().partition(|p| p.power() >= floor);
    let expected: Vec<_> = kept.into_iter().map(bits).collect();
    let found: Vec<_> = cut.paths.iter().map(bits).collect();
    assert_eq!(found, expected);
    assert_eq!(cut.fallback_diffractions, all.fallback_diffractions);
    if cut.fallback_diffractions.is_some() {
        return;
    }
    let count = |link: &Link| link.paths.len() + link.omitted.by_bound + link.omitted.by_gain;
    assert_eq!(count(cut), count(all), "paths kept and left out");
    assert_eq!(all.omitted.by_bound, 0);
    let power: f64 = left_out.iter().map(|p| p.power()).sum();
    assert!(
        cut.omitted.power >= power * (1.0 - 1e-9),
        "{:e} of {power:e} accounted for",
        cut.omitted.power
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn paths_within_the_range_are_those_of_all_paths(
        place in 0..places().len(),
        limits in select(&LIMITS[..]),
        fewer in 0_usize..2,
        slopes in any::<bool>(),
        range_db in select(&[10.0, 17.0, 30.0, 45.0, 60.0, 80.0][..]),
        ends in (0_usize..40, 0_usize..40),
    ) {
        // Three diffractions multiply too much for a whole map.
        prop_assume!(limits.1 < 3 || place < 4);
        let points = &places()[place].2;
        let ends = [points[ends.0], points[ends.1]];
        prop_assume!(ends[0] != ends[1]);
        let all = config(limits, (limits.0 + limits.1).saturating_sub(fewer).max(1), slopes);
        let cut = TraceConfig { dynamic_range_db: Some(range_db), ..all.clone() };
        for ends in [ends, [ends[1], ends[0]]] {
            check(&traced(place, &all, ends), &traced(place, &cut, ends), range_db);
        }
    }
}

/// The search pays for what it finds.
#[test]
fn a_short_range_computes_hardly_more_than_it_keeps() {
    for slopes in [false, true] {
        check_search(slopes);
    }
}

fn check_search(slopes: bool) {
    let (mut kept, mut computed, mut all) = (0, 0, 0);
    for (place, (_, _, points)) in places().iter().enumerate().take(3) {
        let cut = TraceConfig {
            dynamic_range_db: Some(30.0),
            ..config((3, 2), 5, slopes)
        };
        for ends in points.windows(2).take(12) {
            let link = traced(place, &cut, [ends[0], ends[1]]);
            if link.fallback_diffractions.is_none() {
                kept += link.paths.len();
                computed += link.paths.len() + link.omitted.by_gain;
                all += link.paths.len() + link.omitted.by_gain + link.omitted.by_bound;
            }
        }
    }
    eprintln!("slopes {slopes}: {kept} paths kept, {computed} computed, {all} within the limits");
    assert!(all > 10 * kept && computed < 2 * kept);
}
