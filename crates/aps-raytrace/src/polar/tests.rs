//! Ways to corners and corners passed by rays against exhaustion: every sequence of walls, every line against every wall, no views,
//! no index, no exact signs. What lies nearer than [`CLOSE_M`] to a change of mind may be found or not.

use glam::DVec2;
use proptest::prelude::*;

use super::corners::Corner;
use super::fan::Fan;
use super::map::PolarMap;
use super::rays::Passed;
use super::ways::Way;
use crate::scene::{CityConfig, Location, Scene, SceneConfig, Wall, parse_radiomapseer};

const CLOSE_M: f64 = 1e-6;
const SIDE_M: u32 = 160;

fn city(size_m: u32, seed: u64) -> Scene {
    Scene::synthetic(&CityConfig {
        size_m,
        seed,
        ..CityConfig::default()
    })
    .unwrap()
}

/// The first of some scattered places that is outdoors, off the grid of walls.
fn place(scene: &Scene, size_m: u32, seed: u32) -> DVec2 {
    let at = |i: u32| {
        let j = (i + seed).wrapping_mul(2_654_435_761) >> 8;
        DVec2::new(f64::from(j % size_m), f64::from(j / size_m % size_m))
    };
    let outdoor = |p: &DVec2| scene.locate(*p) == Location::Outdoor;
    (0..)
        .map(|i| at(i) + DVec2::new(0.317, 0.441))
        .find(outdoor)
        .unwrap()
}

/// Unit vectors along a wall and out of it.
fn axes(wall: &Wall) -> [DVec2; 2] {
    let along = (wall.b - wall.a).normalize();
    [along, DVec2::new(along.y, -along.x)]
}

/// Length by which a leg goes through a wall that it does not end at; negative if it passes all \[m\].
fn overlap(scene: &Scene, p: DVec2, q: DVec2, is_end: impl Fn(usize) -> bool) -> f64 {
    let walls = scene.walls().iter().enumerate();
    let of_wall = |(id, wall): (usize, &Wall)| {
        let (ray, along, r) = (q - p, wall.b - wall.a, wall.a - p);
        let cross = ray.perp_dot(along);
        let (t, s) = (r.perp_dot(along) / cross, r.perp_dot(ray) / cross);
        match is_end(id) || cross == 0.0 {
            true => f64::NEG_INFINITY,
            false => (t.min(1.0 - t) * ray.length()).min(s.min(1.0 - s) * along.length()),
        }
    };
    walls.map(of_wall).fold(f64::NEG_INFINITY, f64::max)
}

/// Length by which a wall is in the way of a leg to a corner, or the depth at which it arrives there from inside of the building.
fn overlap_to(scene: &Scene, from: DVec2, corner: DVec2, before: Option<usize>) -> f64 {
    let is_face = |wall: &Wall| wall.a == corner || wall.b == corner;
    let faces = scene.walls().iter().filter(|wall| is_face(wall));
    let depth = |wall: &Wall| -(from - corner).dot(axes(wall)[1]);
    let depth = faces.map(depth).fold(f64::INFINITY, f64::min);
    let is_end = |id: usize| before == Some(id) || is_face(&scene.walls()[id]);
    overlap(scene, from, corner, is_end).max(depth)
}

/// A way to a corner, and the length by which something is in its way: negative if it is one \[m\].
struct Candidate {
    length_m: f64,
    unit: DVec2,
    cos_sum: f64,
    obstacle_m: f64,
}

/// The way from a place over walls to a corner; `None` if it is far from being one.
fn candidate(scene: &Scene, from: DVec2, sequence: &[usize], corner: DVec2) -> Option<Candidate> {
    let mut images = vec![from];
    for &id in sequence {
        let wall = &scene.walls()[id];
        let (last, outward) = (images[images.len() - 1], axes(wall)[1]);
        images.push(last - outward * (2.0 * (last - wall.a).dot(outward)));
    }
    let ray = corner - images[images.len() - 1];
    let mut unit = ray.normalize();
    let (mut at, mut before, mut obstacle_m, mut cos_sum) = (corner, None, f64::NEG_INFINITY, 0.0);
    for (i, &id) in sequence.iter().enumerate().rev() {
        let wall = &scene.walls()[id];
        let [along, outward] = axes(wall);
        let heights = [at, images[i]].map(|p| (p - wall.a).dot(outward));
        let lowest = heights[0].min(heights[1]);
        if lowest < -CLOSE_M || (at == corner && (wall.a == corner || wall.b == corner)) {
            return None;
        }
        let point = at.lerp(images[i + 1], heights[0] / (heights[0] + heights[1]));
        let place_m = (point - wall.a).dot(along);
        let beside = (-place_m).max(place_m - wall.length_m()).max(-lowest);
        if beside.is_nan() || beside > CLOSE_M {
            return None;
        }
        let leg = match before {
            None => overlap_to(scene, point, corner, Some(id)),
            Some(other) => overlap(scene, point, at, |wall| wall == id || wall == other),
        };
        obstacle_m = obstacle_m.max(beside).max(leg);
        cos_sum += unit.dot(outward).abs();
        unit -= outward * (2.0 * unit.dot(outward));
        (at, before) = (point, Some(id));
    }
    let first = match before {
        None => overlap_to(scene, from, corner, None),
        Some(id) => overlap(scene, from, at, |wall| wall == id),
    };
    obstacle_m = obstacle_m.max(first);
    (obstacle_m < CLOSE_M).then(|| Candidate {
        length_m: ray.length(),
        unit: ray.normalize(),
        cos_sum,
        obstacle_m,
    })
}

/// Lists the sequences of so many walls, at most two.
fn sequences(walls: usize, order: usize) -> Vec<Vec<usize>> {
    let pairs = || (0..walls).flat_map(|p| (0..walls).map(move |q| vec![p, q]));
    match order {
        0 => vec![Vec::new()],
        1 => (0..walls).map(|id| vec![id]).collect(),
        _ => pairs().filter(|pair| pair[0] != pair[1]).collect(),
    }
}

fn is_same(way: &Way, expected: &Candidate) -> bool {
    let unit = DVec2::new(way.unit[0].into(), way.unit[1].into());
    (f64::from(way.length_m) - expected.length_m).abs() < 1e-4
        && unit.distance(expected.unit) < 1e-5
        && (f64::from(way.cos_sum) - expected.cos_sum).abs() < 1e-5
        && (way.turned_rad, way.corners) == (0.0, 1.0)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, ..ProptestConfig::default() })]

    #[test]
    fn corners_are_lit_over_the_walls_that_exhaustion_finds(seed in 0_u64..1000, at in 0_u32..10_000) {
        let scene = city(SIDE_M, seed);
        let map = PolarMap::new(&scene, Fan::default()).unwrap();
        let from = place(&scene, SIDE_M, at);
        let ways = map.transmitter(from).unwrap();
        let mut counts = [0; 3];
        for (order, count) in counts.iter_mut().enumerate() {
            let sequences = sequences(scene.walls().len(), order);
            for (c, corner) in (0..).zip(&map.corners.corners) {
                let to_corner = |walls: &Vec<usize>| candidate(&scene, from, walls, corner.point);
                let expected: Vec<Candidate> = sequences.iter().filter_map(to_corner).collect();
                let found = ways.to(c, order);
                for way in found {
                    prop_assert!(expected.iter().any(|e| is_same(way, e)), "{way:?} to {}", corner.point);
                }
                let sure: Vec<_> = expected.iter().filter(|e| e.obstacle_m < -CLOSE_M).collect();
                for e in &sure {
                    let is_found = found.iter().any(|way| is_same(way, e));
                    prop_assert!(is_found, "{order} reflections, {} m to {}", e.length_m, corner.point);
                }
                prop_assert!(found.len() <= expected.len());
                *count += sure.len();
            }
        }
        // From a courtyard perhaps no corner is seen.
        prop_assume!(counts.iter().all(|&count| count > 0));
    }

    #[test]
    fn rays_pass_the_corners_that_exhaustion_finds(seed in 0_u64..1000, at in 0_u32..10_000, max_bounces in 0_usize..5) {
        let scene = city(SIDE_M, seed);
        let fan = Fan { directions: 60, max_bounces };
        let map = PolarMap::new(&scene, fan).unwrap();
        let from = place(&scene, SIDE_M, at);
        let rays = map.receiver(from).unwrap();
        let mut count = 0;
        for direction in 0..fan.directions {
            for (bounces, piece) in follow(&scene, from, fan.angle_rad(direction), max_bounces).iter().enumerate() {
                let segment = bounces * fan.directions + direction;
                let passed = rays.passed(segment);
                let cosines = rays.segments[segment].cosines.map(f64::from);
                prop_assert!((cosines[0] - piece.cosines[0]).abs() < 1e-5 && (cosines[1] - piece.cosines[1]).abs() < 1e-5);
                let mut found = 0;
                for (c, corner) in (0..).zip(&map.corners.corners) {
                    let expected = piece.passes(&scene, corner, fan.step_rad());
                    let is_of = |p: &&Passed| p.corner == c;
                    let Some(passed) = passed.iter().find(is_of) else {
                        prop_assert!(expected.obstacle_m > -CLOSE_M, "{segment} misses {}", corner.point);
                        continue;
                    };
                    prop_assert!(expected.obstacle_m < CLOSE_M, "{segment} passes {}", corner.point);
                    prop_assert!((f64::from(passed.range_m) - expected.range_m).abs() < 1e-4);
                    prop_assert!((f64::from(passed.tangent) - expected.tangent).abs() < 1e-5);
                    found += 1;
                }
                prop_assert_eq!(found, passed.len());
                count += found;
            }
        }
        prop_assume!(count > 0);
    }
}

/// A straight piece of a ray.
struct Piece {
    from: DVec2,
    unit: DVec2,
    start_m: f64,
    length_m: f64,
    cosines: [f64; 2],
    /// The wall that it ends at.
    wall: Option<usize>,
}

/// The way from the receiver to a corner beside a piece.
struct Beside {
    range_m: f64,
    tangent: f64,
    /// Length by which it is not beside it, or by which something is in its way \[m\].
    obstacle_m: f64,
}

impl Piece {
    fn passes(&self, scene: &Scene, corner: &Corner, beam_rad: f64) -> Beside {
        let r = corner.point - self.from;
        let (along, across) = (r.dot(self.unit), self.unit.perp_dot(r));
        let foot_m = self.start_m + along;
        let excess = across.abs() - beam_rad * foot_m;
        let is_end = |wall: &Wall| wall.a == corner.point || wall.b == corner.point;
        let ends_there = self.wall.is_some_and(|id| is_end(&scene.walls()[id]));
        // Beyond the wall that it meets a ray is beside the wall's ends only, which are seen along the wall.
        let is_beyond = ends_there && along > self.length_m;
        let beside = excess.max(-along);
        let beside = match is_beyond {
            true => beside.max(self.length_m - along),
            false => beside.max(along - self.length_m),
        };
        let foot = self.from + self.unit * along.min(self.length_m);
        let obstacle_m = match is_beyond {
            true => overlap(scene, foot, corner.point, |id| {
                self.wall == Some(id) || is_end(&scene.walls()[id])
            }),
            false => overlap_to(scene, foot, corner.point, None),
        };
        Beside {
            range_m: foot_m.hypot(across),
            tangent: across / foot_m,
            obstacle_m: match beside < CLOSE_M {
                true => beside.max(obstacle_m),
                false => beside,
            },
        }
    }
}

/// The pieces of a ray up to where it meets a wall within [`CLOSE_M`] of the wall's end.
fn follow(scene: &Scene, from: DVec2, angle_rad: f64, max_bounces: usize) -> Vec<Piece> {
    let (mut p, mut u, mut start_m, mut last) = (from, DVec2::from_angle(angle_rad), 0.0, None);
    let mut cosines = [0.0; 2];
    let mut pieces = Vec::new();
    while pieces.len() <= max_bounces {
        let meets = |(id, wall): (usize, &Wall)| {
            let [along, outward] = axes(wall);
            let distance_m = (p - wall.a).dot(outward) / -u.dot(outward);
            let place_m = (p + u * distance_m - wall.a).dot(along);
            let inside = place_m.min(wall.length_m() - place_m);
            let is_met = Some(id) != last && distance_m > 0.0 && u.dot(outward) < 0.0;
            (is_met && inside > -CLOSE_M).then_some((distance_m, id, inside))
        };
        let all = scene.walls().iter().enumerate().filter_map(meets);
        let first = all.min_by(|p, q| p.0.total_cmp(&q.0));
        if first.is_some_and(|(.., inside)| inside < CLOSE_M) {
            break;
        }
        pieces.push(Piece {
            from: p,
            unit: u,
            start_m,
            length_m: first.map_or(f64::INFINITY, |first| first.0),
            cosines,
            wall: first.map(|first| first.1),
        });
        let Some((distance_m, id, _)) = first else {
            break;
        };
        let outward = axes(&scene.walls()[id])[1];
        cosines = [cosines[0] - u.dot(outward), -u.dot(outward)];
        (p, start_m, last) = (p + u * distance_m, start_m + distance_m, Some(id));
        u -= outward * (2.0 * u.dot(outward));
    }
    pieces
}

#[test]
fn a_corner_between_touching_houses_has_the_walls_beside_the_open_street() {
    // Two needles that touch at a tip with a narrow gap between them.
    let map = "[[[20, 20], [60, 20], [24, 59]], [[20, 20], [17, 40], [-20, 60]]]";
    let config = SceneConfig {
        close_gaps_m: 0.0,
        ..SceneConfig::default()
    };
    let scene = Scene::with_config(&parse_radiomapseer(map).unwrap(), &config).unwrap();
    let map = PolarMap::new(&scene, Fan::default()).unwrap();
    let tip = DVec2::splat(20.0);
    let corners = map.corners.corners.iter();
    let at_tip: Vec<&Corner> = corners.filter(|c| c.point == tip).collect();
    assert_eq!(at_tip.len(), 1);
    let half = (DVec2::X + (DVec2::new(-20.0, 60.0) - tip).normalize()).normalize();
    let inward = at_tip[0].inward;
    assert!(inward.distance(half) < 1e-12, "{inward}");
}
