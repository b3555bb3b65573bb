//! Laws that every path obeys, whatever the city.

use aps_raytrace::glam::DVec2;
use aps_raytrace::{
    Footprint, InteractionKind, Link, Material, PathRecord, Scene, TraceConfig, Tracer,
};
use aps_tests::links::{outdoor_points, with_chains};
use aps_tests::maps::real_cities;
use aps_tests::motion::difference;
use aps_tests::shapes::{city, city_scene};
use proptest::prelude::*;

const SPEED_OF_LIGHT_M_PER_S: f64 = 299_792_458.0;

/// Settings for every kind of path, none left out.
fn mixed() -> TraceConfig {
    TraceConfig {
        max_reflections: 2,
        max_diffractions: 2,
        max_interactions: 3,
        dynamic_range_db: None,
        ..with_chains()
    }
}

/// Largest errors met.
#[derive(Debug, Default)]
struct Errors {
    paths: usize,
    /// Reflection points off their walls, diffraction points off their corners \[m\].
    off_wall_m: f64,
    /// Tangent components before and after a reflection, of unit directions.
    specular: f64,
    /// Length against the sum of legs, relative.
    length: f64,
    /// Azimuths against the points \[rad\].
    azimuth_rad: f64,
}

impl Errors {
    fn check(&mut self, scene: &Scene, tx: DVec2, rx: DVec2, path: &PathRecord) {
        self.paths += 1;
        let mut points = vec![tx];
        points.extend(path.interactions.iter().map(|i| i.point));
        points.push(rx);
        for (i, ends) in path.interactions.iter().zip(points.windows(3)) {
            let (before, at, after) = (ends[0], ends[1], ends[2]);
            let wall = &scene.walls()[i.id as usize];
            if i.kind == InteractionKind::Diffraction {
                assert!(scene.is_convex(i.id));
                self.off_wall_m = self.off_wall_m.max(at.distance(wall.a));
                continue;
            }
            let along = (wall.b - wall.a).normalize();
            let s = (at - wall.a).dot(along);
            let length = wall.length_m();
            assert!(s > -1e-9 && s < length + 1e-9, "beside the wall");
            self.off_wall_m = self.off_wall_m.max((at - wall.a).perp_dot(along).abs());
            // A reflection at a corner, from a corner of the same wall, has no direction to speak of.
            let (d, e) = (at - before, after - at);
            if d.length().min(e.length()) > 1e-6 {
                let (d, e) = (d.normalize(), e.normalize());
                self.specular = self.specular.max((d.dot(along) - e.dot(along)).abs());
                let out = DVec2::new(along.y, -along.x);
                self.specular = self.specular.max((d.dot(out) + e.dot(out)).abs());
                assert!(d.dot(out) < 0.0, "through the wall");
            }
        }
        let legs: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
        self.length = self.length.max((path.length_m / legs - 1.0).abs());
        assert!(
            path.length_m >= tx.distance(rx) * (1.0 - 1e-12),
            "shorter than straight"
        );
        assert_eq!(path.delay_s, path.length_m / SPEED_OF_LIGHT_M_PER_S);
        // Each reflection takes, and no diffraction gives more than there is.
        assert!(path.gain.is_finite() && path.power() > 0.0 && path.power() < 1.0);
        let n = points.len();
        let ends = [
            (path.departure_azimuth_rad, points[1] - points[0]),
            (path.arrival_azimuth_rad, points[n - 2] - points[n - 1]),
        ];
        for (azimuth, towards) in ends {
            assert!(azimuth > -std::f64::consts::PI && azimuth <= std::f64::consts::PI);
            let error = DVec2::from_angle(azimuth).perp_dot(towards) / towards.length();
            assert!(DVec2::from_angle(azimuth).dot(towards) > 0.0, "backwards");
            self.azimuth_rad = self.azimuth_rad.max(error.abs());
        }
    }

    fn assert_small(&self, what: &str) {
        eprintln!("{what}: {self:?}");
        assert!(self.off_wall_m < 1e-9 && self.specular < 1e-6);
        assert!(self.length < 1e-12 && self.azimuth_rad < 1e-12);
    }
}

fn check_laws(scene: &Scene, config: TraceConfig, count: usize, what: &str) -> Errors {
    let tracer = Tracer::new(scene, config).unwrap();
    let points = outdoor_points(scene, count, 77);
    let receivers: Vec<_> = points[..count / 2]
        .iter()
        .map(|&p| tracer.receiver(p).unwrap())
        .collect();
    let mut errors = Errors::default();
    let mut link = Link::default();
    for &tx in &points[count / 2..] {
        let transmitter = tracer.transmitter(tx).unwrap();
        for rx in &receivers {
            tracer.link(&transmitter, rx, &mut link).unwrap();
            let ordered = link.paths.is_sorted_by(|p, q| p.canonical_order(q).is_lt());
            assert!(ordered, "{what}: out of order, or twice");
            for path in &link.paths {
                errors.check(scene, tx, rx.position(), path);
            }
        }
    }
    errors.assert_small(what);
    errors
}

#[test]
fn paths_of_synthetic_and_real_cities_obey_the_laws() {
    let synthetic = |seed| (format!("city {seed}"), city_scene(130, seed), mixed(), 24);
    let real = real_cities(&[0, 33]).into_iter();
    let real = real.map(|(name, scene)| (name, scene, with_chains(), 40));
    for (name, scene, config, count) in (3..=4).map(synthetic).chain(real) {
        let errors = check_laws(&scene, config, count, &name);
        assert!(errors.paths > 1000, "{name}");
    }
}

/// Traces the same links in a scene and in its moved copy: the same paths, their points moved,
/// the same lengths and gains.
fn check_motion(
    footprints: &[Footprint],
    points: &[DVec2],
    config: [&TraceConfig; 2],
    scale: f64,
    motion: impl Fn(DVec2) -> DVec2,
) -> usize {
    let found = difference(footprints, points, config, scale, motion);
    assert!(found.unmatched == 0, "{found:?}");
    assert!(found.length < 1e-12 && found.gain < 1e-8, "{found:?}");
    found.paths
}

/// Quarter turns, whole metres and the turn by atan(4/3), stretched to whole metres, keep every
/// coordinate exact: corners touched before are touched after.
#[test]
fn exact_motions_keep_every_path() {
    let turn = |p: DVec2| DVec2::new(-p.y, p.x);
    let shift = DVec2::new(-1000.0, 345.0);
    // Where ties fall must not depend on the axes.
    let stretched = |p: DVec2| DVec2::new(3.0 * p.x - 4.0 * p.y, 4.0 * p.x + 3.0 * p.y);
    let config = TraceConfig {
        material: Material::PerfectConductor,
        dynamic_range_db: None,
        ..with_chains()
    };
    let slower = TraceConfig {
        frequency_hz: config.frequency_hz / 5.0,
        ..config.clone()
    };
    for seed in 1..=3 {
        let footprints = city(130, seed).footprints().unwrap();
        let points = outdoor_points(&city_scene(130, seed), 14, 5);
        let mut count = check_motion(&footprints, &points, [&config; 2], 1.0, turn);
        count += check_motion(&footprints, &points, [&config; 2], 1.0, |p| -p);
        count += check_motion(&footprints, &points, [&config; 2], 1.0, |p| p + shift);
        count += check_motion(&footprints, &points, [&config, &slower], 5.0, stretched);
        eprintln!("city {seed}: {count} paths the same after exact motions");
        assert!(count > 500);
    }
}

/// Twice the size at half the frequency: the same gains, if the walls' loss tangent is kept.
#[test]
fn twice_the_size_at_half_the_frequency() {
    let wall = |conductivity_s_per_m| Material::Dielectric {
        relative_permittivity: 6.0,
        conductivity_s_per_m,
    };
    let config = TraceConfig {
        material: wall(0.2),
        ..mixed()
    };
    let half = TraceConfig {
        frequency_hz: config.frequency_hz / 2.0,
        material: wall(0.1),
        ..mixed()
    };
    let footprints = city(130, 9).footprints().unwrap();
    let points = outdoor_points(&city_scene(130, 9), 10, 0);
    let count = check_motion(&footprints, &points, [&config, &half], 2.0, |p| p * 2.0);
    assert!(count > 500);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    /// Turned by any angle the set of paths is the same, away from close calls: buildings apart
    /// from each other, slanted, terminals at odd places.
    #[test]
    fn any_turn_keeps_the_paths(
        angle in 0.0_f64..7.0,
        shift in (-500.0_f64..500.0, -500.0_f64..500.0),
        shapes in prop::collection::vec((0.0_f64..6.3, 3.0_f64..9.0, 3.0_f64..9.0), 9),
        ends in prop::collection::vec((1.0_f64..59.0, 0.0_f64..2.0), 5),
    ) {
        let footprints: Vec<Footprint> = shapes
            .iter()
            .zip(0..)
            .map(|(&(tilt, w, h), i)| {
                let centre = DVec2::new(f64::from(i % 3), f64::from(i / 3)) * 30.0;
                let corners = [(-w, -h), (w, -h), (w, h), (-w, h)];
                Footprint::new(corners.map(|c| {
                    centre + DVec2::from_angle(tilt).rotate(c.into()) * 0.9
                }))
            })
            .collect();
        // Along two streets between the rows.
        let points: Vec<DVec2> = ends
            .iter()
            .zip(0..)
            .map(|(&(x, y), i)| DVec2::new(x, 14.0 + y + 30.0 * f64::from(i % 2)))
            .collect();
        let config = mixed();
        let motion = |p: DVec2| DVec2::from_angle(angle).rotate(p) + DVec2::from(shift);
        check_motion(&footprints, &points, [&config; 2], 1.0, motion);
    }
}
