//! Terminals at places where geometry or physics degenerates.

use std::f64::consts::{PI, TAU};

use aps_raytrace::glam::DVec2;
use aps_raytrace::{
    Complex64, Footprint, Link, Material, TerminalError, TraceConfig, TraceError, Tracer,
};
use aps_tests::links::{assert_finite, by_sequence, total_field, with_chains};
use aps_tests::shapes::{points, polygon, rectangle, scene};

const K: f64 = TAU * 3.5e9 / 299_792_458.0;

const MATERIALS: [Material; 4] = [
    Material::Concrete,
    Material::PerfectConductor,
    // No wall at all, electrically.
    Material::Dielectric {
        relative_permittivity: 1.0,
        conductivity_s_per_m: 0.0,
    },
    Material::Dielectric {
        relative_permittivity: 1e5,
        conductivity_s_per_m: 6e7,
    },
];

fn with(material: Material) -> TraceConfig {
    TraceConfig {
        material,
        max_diffractions: 2,
        max_interactions: 4,
        dynamic_range_db: None,
        ..with_chains()
    }
}

fn house() -> Footprint {
    rectangle(0.0, 0.0, 20.0, 10.0)
}

/// Both directions, finite and the same.
fn both_ways(tracer: &Tracer, p: DVec2, q: DVec2, what: &str) -> Link {
    let (forth, back) = (tracer.trace(p, q).unwrap(), tracer.trace(q, p).unwrap());
    assert_finite(&forth, what);
    assert_finite(&back, what);
    let (a, b) = (
        by_sequence(&forth.paths, false),
        by_sequence(&back.paths, true),
    );
    assert_eq!(
        a.keys().collect::<Vec<_>>(),
        b.keys().collect::<Vec<_>>(),
        "{what}"
    );
    for (x, y) in a.values().zip(b.values()) {
        // Paths that cancel to nothing have the rounding of what they cancel from.
        let scale = x.gain.norm().max(1e-9 / x.length_m);
        assert!(
            (x.gain - y.gain).norm() < 1e-9 * scale,
            "{what}: {x:?} {y:?}"
        );
    }
    forth
}

/// A transmitter on the extension of a wall sees it edge-on: angle 0 at the far corner, a
/// reflection coefficient at exactly grazing incidence, both faces of the near corner. All finite
/// for any material, the same in both directions, and the level is that of a micrometre beside: to 1 %
/// of free space for real walls, to 5 % for walls of vacuum, which do not cancel what grazes them; two
/// corners on one line are where the theory's double diffraction has no continuous form.
#[test]
fn transmitter_on_the_extension_of_a_wall() {
    let scene = scene(&[house()]);
    for material in MATERIALS {
        let tracer = Tracer::new(&scene, with(material)).unwrap();
        let txs = points("-8,0 33,10 20,-3").into_iter();
        for (tx, across) in txs.zip([DVec2::Y, DVec2::Y, DVec2::X]) {
            for rx in points("25,-7 26,13 -5,12 40,0 50,10") {
                let what = format!("{material:?}, {tx} -> {rx}");
                let here = total_field(&both_ways(&tracer, tx, rx, &what).paths);
                let scale = 1.0 / (2.0 * K * tx.distance(rx));
                for beside in [1e-6, -1e-6] {
                    let link = both_ways(&tracer, tx + across * beside, rx, &what);
                    let jump = (total_field(&link.paths) - here).norm() / scale;
                    let is_vacuum = material == MATERIALS[2];
                    assert!(jump < if is_vacuum { 0.05 } else { 0.01 }, "{what}: {jump}");
                }
            }
        }
    }
}

/// A receiver in the inner corner of two perfectly conducting walls, down to 1e-9 m from both.
/// The field is that of four images, sum of s_i e^{-jkr_i}/r_i, which goes to zero with the square
/// of the distance: at 1e-9 m sixteen digits cancel, and rounding of each term is all that is left.
#[test]
fn receiver_in_an_inner_corner_sees_four_images_cancel() {
    let scene = scene(&[polygon("0,0 0,90 -5,90 -5,-5 90,-5 90,0")]);
    let config = TraceConfig {
        material: Material::PerfectConductor,
        ..TraceConfig::reflections_only(3)
    };
    let tracer = Tracer::new(&scene, config).unwrap();
    let tx = DVec2::new(31.0, 17.0);
    for d in [1.0, 1e-3, 1e-6, 1e-9] {
        let rx = DVec2::new(d, 2.0 * d);
        let link = both_ways(&tracer, tx, rx, &format!("{d}"));
        assert_eq!(link.paths.len(), 4, "{d}: {:?}", link.paths);
        // To second order: (4 k^2 x y cos sin) of a plane wave; exactly at 1 m, from the images.
        let images = [1.0, -1.0].map(|sx| [1.0, -1.0].map(|sy| (sx, sy, sx * sy)));
        let want: Complex64 = images
            .as_flattened()
            .iter()
            .map(|&(sx, sy, sign)| {
                let r = tx.distance(DVec2::new(sx * rx.x, sy * rx.y));
                Complex64::from_polar(sign / (2.0 * K * r), -K * r)
            })
            .sum();
        let direct = 1.0 / (2.0 * K * tx.distance(rx));
        let error = (total_field(&link.paths) - want).norm() / direct;
        let level = 20.0 * (total_field(&link.paths).norm() / direct).log10();
        eprintln!(
            "{d} m from an inner corner: {level:.0} dB of the direct ray, error {error:.1e} of it"
        );
        // k r is 2600 rad: an ulp of it is 4.5e-13.
        assert!(error < 4e-12);
    }
}

/// A receiver at an outer corner, down to a distance whose square is no longer a number. Waves at
/// a corner are finite, so the level must settle while the receiver approaches, and never overflow.
#[test]
fn receiver_at_an_outer_corner_has_a_finite_level() {
    let scene = scene(&[house()]);
    for material in MATERIALS {
        let tracer = Tracer::new(&scene, with(material)).unwrap();
        let mut levels = Vec::new();
        for exponent in [-3, -6, -9, -12, -15, -18, -30, -100, -170, -300] {
            let d: f64 = 10_f64.powi(exponent);
            let rx = DVec2::new(-d, -2.0 * d);
            for tx in points("-30,-40 30,-8 -7,25") {
                let link = both_ways(&tracer, tx, rx, &format!("{material:?} {d}"));
                let level = total_field(&link.paths).norm() * 2.0 * K * tx.distance(rx);
                // Known limit: nearer than about 1e-16 m the wave of this corner is missing; the level is
                // finite, but that of the direct ray alone.
                if (-15..-9).contains(&exponent) {
                    let before: f64 = levels[levels.len() - 3];
                    assert!(
                        (level - before).abs() < 0.1,
                        "{material:?} {d:e}: {level} {link:?}"
                    );
                }
                levels.push(level);
            }
        }
        eprintln!("{material:?} at an outer corner: {levels:.3?}");
        assert!(levels.iter().all(|&l| l < 3.0));
    }
}

/// Rays that graze: along a wall, through two corners on one side, at angles down to 1e-12 rad.
/// Exactly along a wall the direct ray is there and no reflection; just above it direct and
/// reflected ray cancel to 2 k h_1 h_2 / d of the direct ray on a perfect conductor.
#[test]
fn grazing_rays_cancel_as_two_rays_do() {
    let scene = scene(&[rectangle(-500.0, -1.0, 500.0, 0.0)]);
    let config = TraceConfig {
        material: Material::PerfectConductor,
        ..TraceConfig::reflections_only(2)
    };
    let tracer = Tracer::new(&scene, config).unwrap();
    for height in [1e-3, 1e-6, 1e-9, 1e-12] {
        let (tx, rx) = (DVec2::new(-50.0, height), DVec2::new(50.0, height));
        let link = both_ways(&tracer, tx, rx, &format!("{height}"));
        assert_eq!(link.paths.len(), 2, "{height}");
        let direct = link.paths[0].gain.norm();
        let left = total_field(&link.paths).norm() / direct;
        let want = 2.0 * (K * height * height / 100.0).sin();
        eprintln!("grazing at {height} m: {left:.3e} of the direct ray, {want:.3e} expected");
        // The phase of 100 m is 7336 rad, an ulp of it 9e-13.
        assert!((left - want).abs() < 3e-12);
    }
    // On the wall's line: beside its ends, and over its whole length.
    let [tx, rx] = [-510.0, 600.0].map(|x| DVec2::new(x, 0.0));
    let link = both_ways(&tracer, tx, rx, "along");
    assert_eq!(link.paths.len(), 1);
    assert!(link.paths[0].is_line_of_sight());
}

/// Terminals and a row of houses, all on one line: the ray touches every corner on the same side,
/// and is free; all corners on it are seen behind one another.
#[test]
fn everything_on_one_line() {
    let starts = (0..12).map(|i| 20.0 * f64::from(i));
    let row: Vec<Footprint> = starts.map(|x| rectangle(x, 0.0, x + 10.0, 10.0)).collect();
    let scene = scene(&row);
    for material in MATERIALS {
        let tracer = Tracer::new(&scene, with(material)).unwrap();
        for (p, q) in [(-10.0, 300.0), (-10.0, 15.0), (15.0, 35.0), (15.0, 300.0)] {
            let what = format!("{material:?}: {p} -> {q}");
            let link = both_ways(&tracer, DVec2::new(p, 0.0), DVec2::new(q, 0.0), &what);
            let free = link.paths.iter().filter(|p| p.is_line_of_sight());
            assert_eq!(free.count(), 1, "{what}");
        }
    }
}

/// Two terminals at one place have no link; nor have two so near that 1 / distance^2 is no number.
#[test]
fn coincident_terminals_are_an_error() {
    let one_house = scene(&[house()]);
    let tracer = Tracer::new(&one_house, with_chains()).unwrap();
    let tx = DVec2::new(-1.0, -1.0);
    let is_coincident = |link: &_| matches!(link, Err(TraceError::Coincident { .. }));
    assert!(is_coincident(&tracer.trace(tx, tx)));
    let empty = scene(&[]);
    let tracer = Tracer::new(&empty, with_chains()).unwrap();
    for d in [1e-110, 1e-160, 1e-200, f64::MIN_POSITIVE] {
        let link = tracer.trace(DVec2::ZERO, DVec2::new(d, 0.0));
        assert!(is_coincident(&link), "{d}: {link:?}");
    }
    for d in [1e-3, 1e-9, 1e-15, 1e-90] {
        let link = both_ways(&tracer, DVec2::ZERO, DVec2::new(0.0, d), "near");
        assert!((link.paths[0].gain.norm() * 2.0 * K * d - 1.0).abs() < 1e-12);
    }
}

/// A terminal may stand anywhere a footprint may, within 1e9 m: beyond, products of coordinates
/// overflow, and signs are no longer exact.
#[test]
fn terminals_out_of_this_world_are_refused() {
    let scene = scene(&[house()]);
    let tracer = Tracer::new(&scene, with_chains()).unwrap();
    for far in [1e10, 1e155, 1e200, 1e308, f64::MAX] {
        for place in [(far, 5.0), (-3.0, -far), (far, far)].map(DVec2::from) {
            let refused = tracer.transmitter(place).err();
            assert!(
                matches!(refused, Some(TerminalError::NotFinite(..))),
                "{place}: {refused:?}"
            );
        }
    }
    let (tx, rx) = (DVec2::new(1e9, 1e9), DVec2::new(-1e9, -9e8));
    let link = tracer.trace(tx, rx).unwrap();
    assert_finite(&link, "far");
}

/// Settings at the ends of what is accepted give finite numbers; beyond they are refused by name.
#[test]
fn settings_are_refused_or_give_finite_numbers() {
    let scene = scene(&[house()]);
    let powers = (-308..=308).step_by(4).map(|e| 10_f64.powi(e));
    let (mut accepted, mut refused) = (0, 0);
    for value in powers.chain([5e-324, f64::MAX]) {
        let dielectric = |relative_permittivity, conductivity_s_per_m| Material::Dielectric {
            relative_permittivity,
            conductivity_s_per_m,
        };
        let made = |frequency_hz, material| TraceConfig {
            frequency_hz,
            material,
            ..with_chains()
        };
        let configs = [
            made(value, Material::Concrete),
            made(value, Material::PerfectConductor),
            made(value, dielectric(5.0, 1e3)),
            made(3.5e9, dielectric(1.0 + value, 0.0)),
            made(3.5e9, dielectric(1.0, value)),
            TraceConfig {
                dynamic_range_db: Some(value),
                ..with_chains()
            },
        ];
        for config in configs {
            let Ok(tracer) = Tracer::new(&scene, config.clone()) else {
                refused += 1;
                continue;
            };
            accepted += 1;
            for rx in points("25,-7 -5,12 40,0 50,10") {
                let link = tracer.trace(DVec2::new(-8.0, 0.0), rx).unwrap();
                assert_finite(&link, &format!("{config:?}"));
            }
        }
    }
    eprintln!("{accepted} settings accepted, {refused} refused");
    assert!(accepted > 300);
}

/// Arrival and departure azimuths keep to (-pi, pi], at both ends of the half turn.
#[test]
fn azimuths_at_half_a_turn() {
    let empty = scene(&[]);
    let tracer = Tracer::new(&empty, with_chains()).unwrap();
    for y in [0.0, -0.0, 1e-300, -1e-300, 1e-9, -1e-9] {
        let (tx, rx) = (DVec2::new(3.0, 0.0), DVec2::new(-4.0, y));
        let link = tracer.trace(tx, rx).unwrap();
        let path = &link.paths[0];
        for azimuth in [path.departure_azimuth_rad, path.arrival_azimuth_rad] {
            assert!(azimuth > -PI && azimuth <= PI, "{y}: {azimuth}");
        }
    }
}
