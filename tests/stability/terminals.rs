//! Terminals at places where geometry or physics degenerates.

use std::f64::consts::{PI, TAU};

use aps_raytrace::glam::DVec2;
use aps_raytrace::{
    Complex64, Footprint, Link, Material, Scene, TerminalError, TraceConfig, TraceError, Tracer,
};
use aps_tests::links::{by_sequence, total_field, with_chains};

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
    Footprint::new([(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)].map(DVec2::from))
}

/// No NaN, no infinity, in any number of a link.
fn assert_finite(link: &Link, what: &str) {
    for p in &link.paths {
        let numbers = [
            p.length_m,
            p.delay_s,
            p.departure_azimuth_rad,
            p.arrival_azimuth_rad,
            p.gain.re,
            p.gain.im,
            p.power(),
        ];
        assert!(numbers.iter().all(|v| v.is_finite()), "{what}: {p:?}");
        assert!(
            p.interactions.iter().all(|i| i.point.is_finite()),
            "{what}: {p:?}"
        );
    }
    assert!(link.omitted.power.is_finite(), "{what}: {:?}", link.omitted);
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
    let scene = Scene::new(&[house()], None).unwrap();
    for material in MATERIALS {
        let tracer = Tracer::new(&scene, with(material)).unwrap();
        for (tx, across) in [
            ((-8.0, 0.0), DVec2::Y),
            ((33.0, 10.0), DVec2::Y),
            ((20.0, -3.0), DVec2::X),
        ] {
            let tx = DVec2::from(tx);
            for rx in [
                (25.0, -7.0),
                (26.0, 13.0),
                (-5.0, 12.0),
                (40.0, 0.0),
                (50.0, 10.0),
            ]
            .map(DVec2::from)
            {
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
    let angle = [
        (0.0, 0.0),
        (0.0, 90.0),
        (-5.0, 90.0),
        (-5.0, -5.0),
        (90.0, -5.0),
        (90.0, 0.0),
    ];
    let scene = Scene::new(&[Footprint::new(angle.map(DVec2::from))], None).unwrap();
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
        let images = [
            (1.0, 1.0, 1.0),
            (-1.0, 1.0, -1.0),
            (1.0, -1.0, -1.0),
            (-1.0, -1.0, 1.0),
        ];
        let want: Complex64 = images
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
    let scene = Scene::new(&[house()], None).unwrap();
    for material in MATERIALS {
        let tracer = Tracer::new(&scene, with(material)).unwrap();
        let mut levels = Vec::new();
        for d in [
            1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-18, 1e-30, 1e-100, 1e-170, 1e-300,
        ] {
            let rx = DVec2::new(-d, -2.0 * d);
            for tx in [(-30.0, -40.0), (30.0, -8.0), (-7.0, 25.0)].map(DVec2::from) {
                let link = both_ways(&tracer, tx, rx, &format!("{material:?} {d}"));
                let level = total_field(&link.paths).norm() * 2.0 * K * tx.distance(rx);
                // Known limit: nearer than about 1e-16 m the wave of this corner is missing; the level is
                // finite, but that of the direct ray alone.
                if (1e-15..1e-9).contains(&d) {
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
    let bar = [(-500.0, 0.0), (500.0, 0.0), (500.0, -1.0), (-500.0, -1.0)].map(DVec2::from);
    let scene = Scene::new(&[Footprint::new(bar)], None).unwrap();
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
    let link = both_ways(
        &tracer,
        DVec2::new(-510.0, 0.0),
        DVec2::new(600.0, 0.0),
        "along",
    );
    assert_eq!(link.paths.len(), 1);
    assert!(link.paths[0].is_line_of_sight());
}

/// Terminals and a row of houses, all on one line: the ray touches every corner on the same side,
/// and is free; all corners on it are seen behind one another.
#[test]
fn everything_on_one_line() {
    let row: Vec<Footprint> = (0..12)
        .map(|i| {
            let x = 20.0 * f64::from(i);
            Footprint::new(
                [(x, 0.0), (x + 10.0, 0.0), (x + 10.0, 10.0), (x, 10.0)].map(DVec2::from),
            )
        })
        .collect();
    let scene = Scene::new(&row, None).unwrap();
    for material in MATERIALS {
        let tracer = Tracer::new(&scene, with(material)).unwrap();
        for (p, q) in [(-10.0, 300.0), (-10.0, 15.0), (15.0, 35.0), (15.0, 300.0)] {
            let what = format!("{material:?}: {p} -> {q}");
            let link = both_ways(&tracer, DVec2::new(p, 0.0), DVec2::new(q, 0.0), &what);
            assert_eq!(
                link.paths.iter().filter(|p| p.is_line_of_sight()).count(),
                1,
                "{what}"
            );
        }
    }
}

/// Two terminals at one place have no link; nor have two so near that 1 / distance^2 is no number.
#[test]
fn coincident_terminals_are_an_error() {
    let scene = Scene::new(&[house()], None).unwrap();
    let tracer = Tracer::new(&scene, with_chains()).unwrap();
    let tx = DVec2::new(-1.0, -1.0);
    assert!(matches!(
        tracer.trace(tx, tx),
        Err(TraceError::Coincident { .. })
    ));
    let empty = Scene::new(&[], None).unwrap();
    let tracer = Tracer::new(&empty, with_chains()).unwrap();
    for d in [1e-110, 1e-160, 1e-200, f64::MIN_POSITIVE] {
        let link = tracer.trace(DVec2::ZERO, DVec2::new(d, 0.0));
        assert!(
            matches!(link, Err(TraceError::Coincident { .. })),
            "{d}: {link:?}"
        );
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
    let scene = Scene::new(&[house()], None).unwrap();
    let tracer = Tracer::new(&scene, with_chains()).unwrap();
    for far in [1e10, 1e155, 1e200, 1e308, f64::MAX] {
        for place in [
            DVec2::new(far, 5.0),
            DVec2::new(-3.0, -far),
            DVec2::splat(far),
        ] {
            let refused = tracer.transmitter(place).err();
            assert!(
                matches!(refused, Some(TerminalError::NotFinite(..))),
                "{place}: {refused:?}"
            );
        }
    }
    let link = tracer
        .trace(DVec2::new(1e9, 1e9), DVec2::new(-1e9, -9e8))
        .unwrap();
    assert_finite(&link, "far");
}

/// Settings at the ends of what is accepted give finite numbers; beyond they are refused by name.
#[test]
fn settings_are_refused_or_give_finite_numbers() {
    let scene = Scene::new(&[house()], None).unwrap();
    let powers = (-308..=308).step_by(4).map(|e| 10_f64.powi(e));
    let (mut accepted, mut refused) = (0, 0);
    for value in powers.chain([5e-324, f64::MAX]) {
        let dielectric = |relative_permittivity, conductivity_s_per_m| TraceConfig {
            material: Material::Dielectric {
                relative_permittivity,
                conductivity_s_per_m,
            },
            ..with_chains()
        };
        let frequency = |material| TraceConfig {
            frequency_hz: value,
            material,
            ..with_chains()
        };
        let configs = [
            frequency(Material::Concrete),
            frequency(Material::PerfectConductor),
            frequency(Material::Dielectric {
                relative_permittivity: 5.0,
                conductivity_s_per_m: 1e3,
            }),
            dielectric(1.0 + value, 0.0),
            dielectric(1.0, value),
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
            for rx in [(25.0, -7.0), (-5.0, 12.0), (40.0, 0.0), (50.0, 10.0)].map(DVec2::from) {
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
    let empty = Scene::new(&[], None).unwrap();
    let tracer = Tracer::new(&empty, with_chains()).unwrap();
    for y in [0.0, -0.0, 1e-300, -1e-300, 1e-9, -1e-9] {
        let link = tracer
            .trace(DVec2::new(3.0, 0.0), DVec2::new(-4.0, y))
            .unwrap();
        let path = &link.paths[0];
        for azimuth in [path.departure_azimuth_rad, path.arrival_azimuth_rad] {
            assert!(azimuth > -PI && azimuth <= PI, "{y}: {azimuth}");
        }
    }
}
