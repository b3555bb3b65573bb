//! Maps far from the origin, very small and very large ones.

use std::f64::consts::PI;

use aps_raytrace::glam::DVec2;
use aps_raytrace::{Material, PathRecord, TraceConfig, Tracer};
use aps_tests::links::{corners, outdoor_points, total_field, with_chains};
use aps_tests::motion::difference;
use aps_tests::shapes::{city, city_scene, moved, points, polygon, rectangle, scene};
use aps_tests::utd::{Radio, Wall};

/// Everything up to two reflections and a diffraction, perfect conductors: no path is weak enough
/// to hide a mistake.
fn all_paths() -> TraceConfig {
    TraceConfig {
        material: Material::PerfectConductor,
        dynamic_range_db: None,
        ..with_chains()
    }
}

/// A city at 1e7 m, as UTM northings are, has the paths it has at the origin. Whole metres are
/// whole metres there too, so nothing of the input is lost, and nothing of the result may be: the
/// same sequences, lengths to an ulp and gains to an ulp of the phase (100 m are 7e3 rad). Only the points
/// of interaction, given in the map's coordinates, are rounded to these (1.9e-9 m).
#[test]
fn utm_coordinates_have_the_paths_of_the_origin() {
    let slanted = |p: DVec2| DVec2::new(3.0 * p.x - 4.0 * p.y, 4.0 * p.x + 3.0 * p.y);
    for seed in 1..=2 {
        let footprints = city(130, seed).footprints().unwrap();
        let points = outdoor_points(&city_scene(130, seed), 10, 5);
        for slant in [false, true] {
            let turn = |p: DVec2| if slant { slanted(p) } else { p };
            let footprints = moved(&footprints, turn);
            let points: Vec<DVec2> = points.iter().map(|&p| turn(p)).collect();
            for offset in [(512_345.0, 9_876_543.0), (-1e7, 1e7)].map(DVec2::from) {
                let config = all_paths();
                let d = difference(&footprints, &points, [&config; 2], 1.0, |p| p + offset);
                eprintln!("city {seed}, slant {slant}, offset {offset}: {d:?}");
                assert!(d.paths > 100 && d.unmatched == 0);
                assert!(
                    d.length < 1e-15 && d.gain < 1e-10 && d.point_m < 4e-9,
                    "{d:?}"
                );
            }
        }
    }
}

/// A model city of a thousandth of the size, at a thousand times the frequency, has the same paths
/// with the same gains: nothing in the tracer may depend on the unit of length. At 2^-10 all
/// numbers are scaled exactly, so that the gains are the same to the bit; at 1e-3 walls and places
/// are rounded, which moves phases by 1e-16 of some hundred wavelengths.
#[test]
fn model_city_of_millimetres_has_the_paths_of_the_city() {
    let config = all_paths();
    for (scale, bound) in [(2_f64.powi(-10), 0.0), (1e-3, 1e-9)] {
        let faster = TraceConfig {
            frequency_hz: config.frequency_hz / scale,
            ..config.clone()
        };
        let footprints = city(130, 3).footprints().unwrap();
        let points = outdoor_points(&city_scene(130, 3), 10, 5);
        let d = difference(&footprints, &points, [&config, &faster], scale, |p| {
            p * scale
        });
        eprintln!("city of {} mm: {d:?}", 130e3 * scale);
        // Rounded walls no longer touch the corners they touched.
        assert!(d.paths > 100 && d.unmatched * 50 <= if bound == 0.0 { 0 } else { d.paths });
        assert!(d.length <= 1e-15 && d.gain <= bound, "{d:?}");
    }
}

/// A wall of 2000 km: the two-ray formula, with the far wall ends 1e6 m away. The reflection's
/// length is known from the image, and is met to rounding.
#[test]
fn wall_of_a_thousand_kilometres_makes_two_rays() {
    let scene = scene(&[rectangle(-1e6, -1.0, 1e6, 0.0)]);
    let tracer = Tracer::new(&scene, TraceConfig::reflections_only(1)).unwrap();
    let radio = Radio::of(Wall::Concrete);
    let mut worst = [0.0_f64; 2];
    for (x, y, v) in [(30.0, 4.0, 1.5), (1e4, 2.0, 7.0), (0.25, 1e-3, 40.0)] {
        let (tx, rx) = (DVec2::new(7.0, y), DVec2::new(7.0 + x, v));
        let paths = tracer.trace(tx, rx).unwrap().paths;
        assert_eq!(paths.len(), 2);
        let length_m = x.hypot(y + v);
        let gain = radio.spherical_wave(length_m) / length_m
            * radio.reflection(PI / 2.0 - ((y + v) / length_m).asin());
        worst[0] = worst[0].max((paths[1].length_m / length_m - 1.0).abs());
        worst[1] = worst[1].max((paths[1].gain / gain - 1.0).norm());
    }
    eprintln!(
        "wall of 2000 km: length {:.1e}, gain {:.1e}",
        worst[0], worst[1]
    );
    assert!(worst[0] < 4e-16 && worst[1] < 1e-9);
}

/// A corner cut off by walls of 1e-9 m and of 1e-6 m: what reflects on the long walls stays as it
/// is, and no path comes out infinite or stronger than free space over its length, though legs
/// between the two new corners are 1e-9 m long.
#[test]
fn walls_of_a_nanometre_change_no_other_path() {
    let config = TraceConfig {
        max_diffractions: 2,
        max_interactions: 4,
        ..all_paths()
    };
    let ends = points("-7,-5 30,-4 25,22 -3,15");
    let mut over_the_cut = 0;
    for cut in [1e-9, 1e-6] {
        let chamfered = polygon(&format!("0,0 {},0 20,{cut} 20,10 0,10", 20.0 - cut));
        let scenes = [rectangle(0.0, 0.0, 20.0, 10.0), chamfered].map(|f| scene(&[f]));
        assert_eq!(scenes[1].walls().len(), 5);
        let tracers = scenes
            .each_ref()
            .map(|s| Tracer::new(s, config.clone()).unwrap());
        for (i, &tx) in ends.iter().enumerate() {
            for &rx in &ends[..i] {
                let [before, after] = tracers.each_ref().map(|t| t.trace(tx, rx).unwrap().paths);
                let friis = |length_m: f64| 299_792_458.0 / 3.5e9 / (4.0 * PI * length_m);
                for path in &after {
                    assert!(path.gain.is_finite() && path.length_m.is_finite());
                    assert!(path.gain.norm() <= 2.0 * friis(path.length_m), "{path:?}");
                    // Over the wall that cuts the corner off: less of it the shorter it is.
                    let mut legs = path.interactions.windows(2);
                    if legs.any(|i| i[0].point.distance(i[1].point) < 2.0 * cut) {
                        let strength = path.gain.norm() / friis(path.length_m);
                        assert!(strength <= 100.0 * cut.sqrt(), "{strength:e}: {path:?}");
                        over_the_cut += 1;
                    }
                }
                let specular = |paths: &[PathRecord]| -> Vec<f64> {
                    let specular = paths.iter().filter(|p| corners(p) == 0);
                    specular.map(|p| p.length_m).collect()
                };
                assert_eq!(specular(&before), specular(&after), "{tx} -> {rx}");
                let levels = [before, after].map(|p| total_field(&p).norm());
                assert!(levels.iter().all(|l| l.is_finite()));
            }
        }
    }
    assert!(over_the_cut > 0);
}
