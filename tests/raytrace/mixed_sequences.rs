//! Line of sight, R, D, R-D and D-R against exhaustion: the same paths, lengths and gains.

use aps_raytrace::{Material, Scene, Tracer};
use aps_tests::links::{by_sequence, one_of_each, outdoor_points, strongest};
use aps_tests::maps::real_cities;
use aps_tests::mixed::mixed_candidates;
use aps_tests::shapes::city_scene;
use aps_tests::utd::{MATERIALS, Radio, Wall};

/// Decisions closer than this [m] may fall either way.
const TOLERANCE_M: f64 = 1e-7;

/// Nearer to a boundary than this [rad] the textbook's formula loses its digits.
const OFF_BOUNDARY_RAD: f64 = 1e-5;

/// Paths, by what was done with them.
#[derive(Debug, Default)]
struct Tally {
    compared: usize,
    /// With a corner.
    diffracted: usize,
    /// With a corner and a wall.
    mixed: usize,
    /// Too close to call.
    close: usize,
    on_boundary: usize,
    /// Largest error of a gain, relative.
    worst: f64,
}

fn check(scene: &Scene, material: Material, wall: Wall, counts: [usize; 2]) -> Tally {
    let radio = Radio::of(wall);
    let tracer = Tracer::new(scene, one_of_each(material)).unwrap();
    let mut tally = Tally::default();
    for &tx in &outdoor_points(scene, counts[0], 300) {
        // Near links have more paths.
        let near = outdoor_points(scene, 40 * counts[1], 9_000);
        let near = near.iter().filter(|p| p.distance(tx) < 70.0 && **p != tx);
        for &rx in near.take(counts[1]) {
            let paths = tracer.trace(tx, rx).unwrap().paths;
            let mut traced = by_sequence(&paths, false);
            // Gains that cancel are compared to the strongest path.
            let floor = strongest(&paths).sqrt() * 1e-6;
            for c in mixed_candidates(scene.walls(), radio, tx, rx, TOLERANCE_M) {
                let Some(path) = traced.remove(&c.sequence) else {
                    let close = c.clearance_m < TOLERANCE_M || c.gain.norm() < floor * 1e-6;
                    assert!(close, "{tx} -> {rx}: {c:?} was missed");
                    tally.close += 1;
                    continue;
                };
                let error = (path.length_m - c.length_m).abs() / c.length_m;
                assert!(
                    error < 1e-9,
                    "{tx} -> {rx}: length of {c:?} off by {error:e}"
                );
                if c.off_boundary_rad < OFF_BOUNDARY_RAD {
                    tally.on_boundary += 1;
                    continue;
                }
                let error = (path.gain - c.gain).norm() / c.gain.norm().max(floor);
                assert!(error < 1e-6, "{tx} -> {rx}: gain {} of {c:?}", path.gain);
                tally.worst = tally.worst.max(error);
                tally.compared += 1;
                if c.off_boundary_rad.is_finite() {
                    tally.diffracted += 1;
                    tally.mixed += usize::from(c.sequence.len() == 2);
                }
            }
            assert!(
                traced.is_empty(),
                "{tx} -> {rx}: {:?} are no paths",
                traced.keys()
            );
        }
    }
    tally
}

fn report(what: &str, tally: &Tally) {
    eprintln!(
        "{what}, gains differ by {:.1e} at most: {tally:?}",
        tally.worst
    );
    let compared = tally.compared;
    assert!(tally.mixed > 50 && tally.close < compared / 5 && tally.on_boundary < compared / 20);
}

#[test]
fn synthetic_cities_of_concrete_and_of_metal() {
    for seed in 1..=3 {
        let scene = city_scene(256, seed);
        for (material, wall) in MATERIALS {
            let tally = check(&scene, material, wall, [5, 14]);
            report(&format!("city {seed}, {wall:?}"), &tally);
        }
    }
}

#[test]
fn real_cities_of_concrete() {
    for (name, scene) in real_cities(&[0, 1, 21, 48]) {
        let tally = check(&scene, Material::Concrete, Wall::Concrete, [4, 10]);
        report(&name, &tally);
    }
}
