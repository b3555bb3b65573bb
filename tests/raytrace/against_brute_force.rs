//! The tracer finds the paths that exhaustion finds, no more and no fewer.

use aps_raytrace::{Scene, TraceConfig, Tracer};
use aps_tests::brute_force::candidates;
use aps_tests::links::outdoor_points;
use aps_tests::maps::real_cities;
use aps_tests::shapes::city_scene;

/// Decisions closer than this [m] may fall either way.
const TOLERANCE_M: f64 = 1e-7;

/// Returns how many paths were compared and how many were too close to call.
fn check(scene: &Scene, tx_count: usize, rx_count: usize) -> (usize, usize) {
    let tracer = Tracer::new(scene, TraceConfig::reflections_only(2)).unwrap();
    let (mut compared, mut close) = (0, 0);
    for &tx in &outdoor_points(scene, tx_count, 0) {
        // Near links have paths; far ones are mostly hidden.
        let near = outdoor_points(scene, 40 * rx_count, 9_000);
        let near = near.iter().filter(|p| p.distance(tx) < 60.0 && **p != tx);
        for &rx in near.take(rx_count) {
            let traced = tracer.trace(tx, rx).unwrap().paths;
            let expected = candidates(scene.walls(), tx, rx, 2, TOLERANCE_M);
            for path in &traced {
                let walls: Vec<u32> = path.interactions.iter().map(|i| i.id).collect();
                let twin = expected.iter().find(|c| c.walls == walls);
                let Some(twin) = twin else {
                    panic!("{tx} -> {rx}: {walls:?} is no path");
                };
                let error = (path.length_m - twin.length_m).abs() / twin.length_m;
                assert!(
                    error < 1e-9,
                    "{tx} -> {rx}: {walls:?} length off by {error}"
                );
                compared += 1;
            }
            for c in expected {
                let found = traced.iter().any(|p| {
                    p.interactions
                        .iter()
                        .map(|i| i.id)
                        .eq(c.walls.iter().copied())
                });
                if c.clearance_m > TOLERANCE_M {
                    assert!(
                        found,
                        "{tx} -> {rx}: {:?} was missed by {}",
                        c.walls, c.clearance_m
                    );
                } else {
                    close += 1;
                }
            }
        }
    }
    (compared, close)
}

#[test]
fn paths_of_order_two_in_synthetic_and_real_cities() {
    let synthetic = |seed| (format!("city {seed}"), city_scene(256, seed), [5, 12]);
    let real = real_cities(&[0, 1, 21, 48]).into_iter();
    let real = real.map(|(name, scene)| (name, scene, [4, 12]));
    for (name, scene, [tx_count, rx_count]) in (1..=3).map(synthetic).chain(real) {
        let (compared, close) = check(&scene, tx_count, rx_count);
        let walls = scene.walls().len();
        eprintln!("{name}: {walls} walls, {compared} paths, {close} too close to call");
        assert!(compared > 40 && close < compared / 10, "{name}");
    }
}
