//! Fields against what the tracer and exhaustive search say at single pixels and along single rays.

use aps_raytrace::fields::{
    Field, FieldConfig, FieldError, FieldGrid, FieldLink, FieldMap, Mirror, NUMBERS, PLANES,
    TransmitterFields, gather,
};
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::{CityConfig, Location};
use aps_raytrace::{Area, Footprint, Scene, TraceConfig, Tracer};
use aps_tests::brute_force::candidates;
use aps_tests::links::outdoor_points;

/// Decisions closer than this \[m\] may fall either way.
const TOLERANCE_M: f64 = 1e-7;

/// Rounding of lengths to f32 \[m\].
const ROUNDING_M: f64 = 2e-4;

fn city(seed: u64) -> Scene {
    let config = CityConfig {
        seed,
        ..CityConfig::default()
    };
    Scene::synthetic(&config).unwrap()
}

fn map(scene: &Scene) -> FieldMap<'_> {
    FieldMap::new(scene, FieldConfig::default()).unwrap()
}

/// Some pixels with an outdoor centre, scattered.
fn pixels(scene: &Scene, map: &FieldMap<'_>, count: usize) -> Vec<usize> {
    let scattered = (0..).map(|i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as usize);
    let on_grid = scattered.map(|i| i % map.grid().pixels());
    let outdoor =
        on_grid.filter(|&pixel| scene.locate(map.grid().centre(pixel)) == Location::Outdoor);
    outdoor.take(count).collect()
}

/// Returns how many lengths were compared.
fn check_against_tracer(scene: &Scene, tx: DVec2, count: usize) -> usize {
    let map = map(scene);
    let fields = map.transmitter(tx).unwrap();
    let in_sight = fields.in_sight();
    let [once, twice] = [Field::Once, Field::Twice].map(|field| fields.lengths_m(&map, field));
    let tracer = Tracer::new(scene, TraceConfig::reflections_only(2)).unwrap();
    let mut compared = 0;
    for pixel in pixels(scene, &map, count) {
        let centre = map.grid().centre(pixel);
        let paths = tracer.trace(tx, centre).unwrap().paths;
        let shortest = |order: usize| {
            let of_order = paths.iter().filter(|p| p.interactions.len() == order);
            of_order.map(|p| p.length_m).fold(f64::INFINITY, f64::min)
        };
        let sight = match in_sight[pixel] {
            1 => tx.distance(centre),
            _ => f64::INFINITY,
        };
        for (order, found) in [sight, once[pixel].into(), twice[pixel].into()]
            .into_iter()
            .enumerate()
        {
            let expected = shortest(order);
            compared += usize::from(expected.is_finite());
            if found == expected || (found - expected).abs() < ROUNDING_M {
                continue;
            }
            // Only a decision too close to call may come out otherwise.
            let close = candidates(scene.walls(), tx, centre, order, 1e-6);
            let is_close = close.iter().any(|c| {
                c.walls.len() == order
                    && c.clearance_m.abs() < 1e-6
                    && (c.length_m - found.min(expected)).abs() < ROUNDING_M
            });
            assert!(
                is_close,
                "{tx} to {centre}, {order} reflections: {found} m instead of {expected} m; {close:?}"
            );
        }
    }
    compared
}

#[test]
fn pixels_in_sight_and_lit_by_reflections_are_those_with_such_a_path() {
    let mut compared = 0;
    for seed in 1..=4 {
        let scene = city(seed);
        for tx in outdoor_points(&scene, 3, seed as u32) {
            compared += check_against_tracer(&scene, tx, 1000);
        }
    }
    assert!(compared > 2000, "{compared}");
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
        let step = |p: &DVec2, q: &DVec2| match scene.is_blocked(*p, *q, [None; 2]) {
            true => f64::INFINITY,
            false => p.distance(*q),
        };
        let steps_m = corners
            .iter()
            .map(|p| corners.iter().map(|q| step(p, q)).collect());
        Self {
            scene,
            steps_m: steps_m.collect(),
            corners,
        }
    }

    /// Lengths to the corners (Bellman 1958).
    fn to_corners(&self, from: DVec2) -> Vec<f64> {
        let mut lengths: Vec<f64> = self.corners.iter().map(|&c| self.step(from, c)).collect();
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

    fn step(&self, p: DVec2, q: DVec2) -> f64 {
        match self.scene.is_blocked(p, q, [None; 2]) {
            true => f64::INFINITY,
            false => p.distance(q),
        }
    }

    fn shortest(&self, from: DVec2, to_corners: &[f64], to: DVec2) -> f64 {
        let over = self.corners.iter().zip(to_corners);
        let over = over.map(|(&corner, length)| length + self.step(corner, to));
        over.fold(self.step(from, to), f64::min)
    }
}

#[test]
fn shortest_ways_are_those_over_all_corners_and_pairs() {
    for seed in 1..=4 {
        let scene = city(seed);
        let map = map(&scene);
        let exhaustive = Exhaustive::new(&scene);
        for tx in outdoor_points(&scene, 2, seed as u32) {
            let fields = map.transmitter(tx).unwrap();
            let found = fields.lengths_m(&map, Field::Geodesic);
            let to_corners = exhaustive.to_corners(tx);
            for pixel in pixels(&scene, &map, 1500) {
                let centre = map.grid().centre(pixel);
                let expected = exhaustive.shortest(tx, &to_corners, centre);
                let found = f64::from(found[pixel]);
                assert!(
                    found == expected || (found - expected).abs() < ROUNDING_M,
                    "{tx} to {centre}: {found} m instead of {expected} m"
                );
            }
            for rx in outdoor_points(&scene, 100, 77) {
                let receiver = map.receiver(rx).unwrap();
                let link = FieldLink {
                    map: &map,
                    transmitter: &fields,
                    receiver: &receiver,
                    mirror: Mirror::default(),
                };
                let expected = exhaustive.shortest(tx, &to_corners, rx);
                let found = link.geodesic_m();
                assert!(found == expected || (found - expected).abs() < 1e-9);
            }
        }
    }
}
