//! The paths of the tracer are among the ways that rays of the polar view find.

use std::f64::consts::PI;

use aps_raytrace::glam::DVec2;
use aps_raytrace::polar::{FEATURES, Fan, KINDS, PER_WAY, PolarLink, PolarMap};
use aps_raytrace::{InteractionKind, PathRecord, Scene, TraceConfig, Tracer};
use aps_tests::links::outdoor_points;
use aps_tests::maps::real_cities;
use aps_tests::shapes::city_scene;

const FAN: Fan = Fan {
    directions: 720,
    max_bounces: 2,
};

/// A path in the terms of [`PolarLink`].
struct Sought {
    kind: usize,
    bounces: usize,
    length_m: f64,
    /// Turn at the corner \[rad\]; zero without one.
    turn_rad: f64,
    /// Rank among the ways over a corner.
    rank: f64,
}

impl Sought {
    fn new(path: &PathRecord, tx: DVec2, rx: DVec2) -> Self {
        let is_corner = |kind| kind == InteractionKind::Diffraction;
        let corner = path.interactions.iter().position(|i| is_corner(i.kind));
        let points: Vec<DVec2> = [tx]
            .into_iter()
            .chain(path.interactions.iter().map(|i| i.point))
            .chain([rx])
            .collect();
        let count = path.interactions.len();
        let Some(corner) = corner else {
            return Self {
                kind: 0,
                bounces: count,
                length_m: path.length_m,
                turn_rad: 0.0,
                rank: 0.0,
            };
        };
        let leg = |i: usize| points[i + 1] - points[i];
        let (first, last) = (0..=corner, corner + 1..=count);
        let [s2, s1] = [first, last].map(|legs| legs.map(|i| leg(i).length()).sum::<f64>());
        // Half of the angle between what arrives and what leaves is that to the wall's normal.
        let cosine = |i: usize| (0.5 * leg(i).angle_to(-leg(i + 1)).abs()).cos();
        let cos_sum: f64 = (0..corner).map(cosine).sum();
        let turn_rad = leg(corner).angle_to(leg(corner + 1)).abs();
        let chord = 2.0 * (0.5 * turn_rad).sin();
        Self {
            kind: 1 + corner,
            bounces: count - corner - 1,
            length_m: path.length_m,
            turn_rad,
            rank: (chord + 0.05).powi(2) * s1 * s2 * (s1 + s2) * cos_sum.exp(),
        }
    }

    /// Tells if a way is this path, as far as rounding goes.
    fn is(&self, way: &[f32]) -> bool {
        let length_m = ((f64::from(way[11]) + 1.0) / 0.3).exp();
        let turn_rad = f64::from(way[4]) * PI;
        (length_m / self.length_m - 1.0).abs() < 1e-5 && (turn_rad - self.turn_rad).abs() < 1e-3
    }

    /// Tells if a way ranks before this path, or beside it within rounding.
    fn is_after(&self, way: &[f32]) -> bool {
        let [turn, product, length] = [4, 6, 11].map(|i| f64::from(way[i]));
        let chord = 2.0 * (0.5 * turn * PI).sin();
        let length_m = ((length + 1.0) / 0.3).exp();
        // s1 s2 / (s1 + s2), times the square of the sum.
        let product = (product / 0.3).exp() * length_m * length_m;
        let rank = (chord + 0.05).powi(2) * product * f64::from(way[10]).exp();
        self.kind > 0 && rank < self.rank * (1.0 + 1e-4)
    }
}

/// Paths found, those behind another way of their kind, and those missed.
#[derive(Debug, Default)]
struct Shares {
    found: usize,
    behind: usize,
    missed: usize,
}

impl Shares {
    fn count(&mut self, is_found: bool, is_behind: bool) {
        match (is_found, is_behind) {
            (true, _) => self.found += 1,
            (_, true) => self.behind += 1,
            _ => self.missed += 1,
        }
    }

    fn all(&self) -> f64 {
        (self.found + self.behind + self.missed) as f64
    }

    fn found(&self) -> f64 {
        self.found as f64 / self.all()
    }

    fn missed(&self) -> f64 {
        self.missed as f64 / self.all()
    }
}

/// Shares of all paths and of the strongest of each link.
fn shares(scene: &Scene, count: usize) -> [Shares; 2] {
    let config = TraceConfig {
        max_reflections: 2,
        max_diffractions: 1,
        ..TraceConfig::default()
    };
    let tracer = Tracer::new(scene, config).unwrap();
    let map = PolarMap::new(scene, FAN).unwrap();
    let points = outdoor_points(scene, count, 17);
    let (tx, rx) = points.split_at(count / 4);
    let mut shares: [Shares; 2] = Default::default();
    let mut ways = Vec::new();
    for &tx in tx {
        let transmitter = map.transmitter(tx).unwrap();
        for &rx in rx {
            let receiver = map.receiver(rx).unwrap();
            let link = PolarLink {
                map: &map,
                transmitter: &transmitter,
                receiver: &receiver,
            };
            ways.clear();
            link.ways(&mut ways).unwrap();
            let paths = tracer.trace(tx, rx).unwrap().paths;
            let power = |p: &&PathRecord| p.power();
            let strongest = paths.iter().max_by(|p, q| power(p).total_cmp(&power(q)));
            for path in &paths {
                let sought = Sought::new(path, tx, rx);
                if sought.kind + 1 >= KINDS || sought.bounces > FAN.max_bounces {
                    continue;
                }
                let turns = path.arrival_azimuth_rad.rem_euclid(2.0 * PI) / FAN.step_rad();
                let nearest = turns.floor() as usize % FAN.directions;
                let other = if turns.fract() < 0.5 {
                    FAN.directions - 1
                } else {
                    1
                };
                // The rays on both sides of the path.
                let beside = [nearest, (nearest + other) % FAN.directions];
                let kind = sought.kind * (FAN.max_bounces + 1) + sought.bounces;
                let along = |direction: usize| {
                    let is_along = move |way: &&[f32]| {
                        [way[FEATURES], way[FEATURES + 1]] == [direction as f32, kind as f32]
                    };
                    ways.chunks_exact(PER_WAY).filter(is_along)
                };
                let is_found = beside
                    .iter()
                    .any(|&ray| along(ray).any(|way| sought.is(way)));
                let before = |ray: usize| along(ray).any(|way| sought.is_after(way));
                let is_behind = beside.iter().any(|&ray| before(ray));
                shares[0].count(is_found, is_behind);
                if strongest.is_some_and(|s| std::ptr::eq(s, path)) {
                    shares[1].count(is_found, is_behind);
                }
            }
        }
    }
    shares
}

/// Missed paths lie between two rays, as in a slit.
#[test]
fn rays_find_most_paths_that_no_other_hides() {
    let mut cities = real_cities(&[0, 21]);
    cities.push(("synthetic".into(), city_scene(256, 3)));
    for (name, scene) in cities {
        let [all, strongest] = shares(&scene, 48);
        println!(
            "{name}: {:.1} % missed of all, {all:?}, {:.1} % of the strongest of a link, {strongest:?}",
            100.0 * all.missed(),
            100.0 * strongest.missed()
        );
        assert!(all.found + all.behind > 4000, "{name}");
        assert!(all.missed() < 0.02 && all.found() > 0.8, "{name}");
        assert!(
            strongest.missed() < 0.02 && strongest.found() > 0.94,
            "{name}"
        );
    }
}
