//! Scenes whose paths can be written down: free space, one wall, a street canyon.

use std::f64::consts::PI;

use aps_raytrace::glam::DVec2;
use aps_raytrace::{Complex64, Footprint, InteractionKind, Material, TraceConfig, Tracer};
use aps_tests::links::{total_field, with_chains};
use aps_tests::shapes::{moved, rectangle, scene};
use aps_tests::utd::{MATERIALS, Radio, Wall};

const FREQUENCY_HZ: f64 = 3.5e9;

/// Gain after unfolding: length, equal reflections, cosine of their angle of incidence.
fn unfolded_gain(wall: Wall, length_m: f64, reflections: i32, cos_incidence: f64) -> Complex64 {
    let radio = Radio::of(wall);
    let gamma = radio.reflection(cos_incidence.acos());
    radio.spherical_wave(length_m) / length_m * gamma.powi(reflections)
}

/// A bar of 2 km x 1 m, its street side from (-1000, y) to (1000, y); `up` tells where the
/// street is. Turned about the origin.
fn bar(y: f64, up: bool, turn: DVec2) -> Footprint {
    let [low, high] = if up { [y - 1.0, y] } else { [y, y + 1.0] };
    moved(&[rectangle(-1e3, low, 1e3, high)], |p| turn.rotate(p)).remove(0)
}

#[test]
fn free_space_is_friis() {
    let scene = scene(&[]);
    let tracer = Tracer::new(&scene, with_chains()).unwrap();
    let mut worst = 0.0_f64;
    for distance_m in [1e-3, 1.0, 100.0, 12_345.6] {
        let (tx, rx) = (DVec2::new(3.0, 4.0), DVec2::new(3.0 + distance_m, 4.0));
        let paths = tracer.trace(tx, rx).unwrap().paths;
        assert_eq!(paths.len(), 1);
        let loss_db = 20.0 * (4.0 * PI * distance_m * FREQUENCY_HZ / 299_792_458.0).log10();
        worst = worst.max((paths[0].gain_db() + loss_db).abs());
    }
    eprintln!("free space: {worst:.1e} dB from Friis");
    assert!(worst < 1e-9);
    // The handbook's 32.45 + 20 log10(f/MHz) + 20 log10(d/km), at 100 m.
    let (tx, rx) = (DVec2::ZERO, DVec2::new(0.0, 100.0));
    let paths = tracer.trace(tx, rx).unwrap().paths;
    assert!((paths[0].gain_db() + 83.33).abs() < 0.01);
}

fn lossless(relative_permittivity: f64) -> Material {
    Material::Dielectric {
        relative_permittivity,
        conductivity_s_per_m: 0.0,
    }
}

#[test]
fn reflection_coefficient_over_all_angles() {
    let mut worst = 0.0_f64;
    for (material, wall) in MATERIALS {
        let reflector = material.at(FREQUENCY_HZ);
        for i in 0..=900 {
            let incidence = f64::from(i).to_radians() / 10.0;
            let expected = Radio::of(wall).reflection(incidence);
            worst = worst.max((reflector.reflection(incidence.cos()) - expected).norm());
        }
        let grazing = reflector.reflection(0.0);
        assert!((grazing + 1.0).norm() < 1e-15, "{material:?}: {grazing}");
    }
    eprintln!("reflection coefficient: {worst:.1e} from Fresnel's and Snell's laws");
    assert!(worst < 1e-14);
    // Grazing is approached as -1 + 2 cos / sqrt(eps - 1).
    let near_grazing = lossless(5.0).at(FREQUENCY_HZ).reflection(1e-4);
    assert!((near_grazing + 1.0 - 1e-4).norm() < 1e-7, "{near_grazing}");
}

#[test]
fn reflection_coefficient_at_normal_incidence() {
    // Lossless, eps = 4: (1 - 2) / (1 + 2).
    let gamma = lossless(4.0).at(FREQUENCY_HZ).reflection(1.0);
    assert!((gamma + 1.0 / 3.0).norm() < 1e-15);
    // Concrete: eps = 5.24 - j 0.0462 * 3.5^0.7822 / (2 pi 3.5e9 eps_0).
    let sigma: f64 = 0.0462 * 3.5_f64.powf(0.7822);
    let eps = Complex64::new(
        5.24,
        -sigma / (2.0 * PI * FREQUENCY_HZ * 8.854_187_812_8e-12),
    );
    let expected = (1.0 - eps.sqrt()) / (1.0 + eps.sqrt());
    let gamma = Material::Concrete.at(FREQUENCY_HZ).reflection(1.0);
    assert!((gamma - expected).norm() < 1e-15);
    // -8.1 dB: what a facade gives back head-on.
    assert!((20.0 * gamma.norm().log10() + 8.1).abs() < 0.1);
}

#[test]
fn one_wall_makes_two_rays_interfere() {
    let scene = scene(&[bar(0.0, true, DVec2::X)]);
    for (material, wall) in MATERIALS {
        let config = TraceConfig {
            material,
            ..TraceConfig::reflections_only(3)
        };
        let tracer = Tracer::new(&scene, config).unwrap();
        let radio = Radio::of(wall);
        let (mut worst, mut low, mut high) = (0.0_f64, f64::INFINITY, 0.0_f64);
        for i in 0..2000 {
            // Heights 4 m and 1.5 m above the wall, 1 m to 400 m apart.
            let x = 400.0_f64.powf(f64::from(i) / 1999.0);
            let (tx, rx) = (DVec2::new(-200.0, 4.0), DVec2::new(-200.0 + x, 1.5));
            let (direct, reflected) = (x.hypot(2.5), x.hypot(5.5));
            let gamma = radio.reflection((x / reflected).asin());
            let expected = radio.spherical_wave(direct) / direct
                + radio.spherical_wave(reflected) / reflected * gamma;
            let paths = tracer.trace(tx, rx).unwrap().paths;
            assert_eq!(paths.len(), 2);
            let scale = radio.spherical_wave(direct).norm() / direct;
            let error = (total_field(&paths) - expected).norm() / scale;
            worst = worst.max(error);
            let level = expected.norm() / scale;
            (low, high) = (low.min(level), high.max(level));
        }
        eprintln!(
            "two rays, {material:?}: error {worst:.1e} of the direct ray; fading {:.0} to {:.1} dB",
            20.0 * low.log10(),
            20.0 * high.log10()
        );
        assert!(worst < 1e-10);
    }
}

#[test]
fn street_canyon_is_the_image_series() {
    const ORDERS: i32 = 12;
    let width = 17.0;
    let (mut worst_length, mut worst_gain, mut count) = (0.0_f64, 0.0_f64, 0);
    for turn in [0.0, 0.7].map(DVec2::from_angle) {
        let scene = scene(&[bar(0.0, true, turn), bar(width, false, turn)]);
        for (material, wall) in MATERIALS {
            let config = TraceConfig {
                material,
                ..TraceConfig::reflections_only(ORDERS as usize)
            };
            let tracer = Tracer::new(&scene, config).unwrap();
            for (y, x, v) in [(3.0, 0.0, 11.0), (3.0, 40.0, 16.5), (8.5, 200.0, 2.0)] {
                let at = |x: f64, y: f64| turn.rotate(DVec2::new(x, y));
                let paths = tracer.trace(at(-10.0, y), at(-10.0 + x, v)).unwrap().paths;
                // Images of the transmitter at 2 k width + y and 2 k width - y.
                let mut expected: Vec<(f64, i32, f64)> = (-ORDERS..=ORDERS)
                    .flat_map(|k| {
                        let shift = 2.0 * f64::from(k) * width;
                        [(shift + y, (2 * k).abs()), (shift - y, (2 * k - 1).abs())]
                    })
                    .filter(|image| image.1 <= ORDERS)
                    .map(|(image, order)| (x.hypot(image - v), order, (image - v).abs()))
                    .collect();
                expected.sort_by(|p, q| p.0.total_cmp(&q.0));
                assert_eq!(paths.len(), 25);
                assert_eq!(expected.len(), 25);
                for (path, (length_m, order, across)) in paths.iter().zip(expected) {
                    assert_eq!(path.interactions.len(), order as usize);
                    let mut kinds = path.interactions.iter().map(|i| i.kind);
                    assert!(kinds.all(|k| k == InteractionKind::Reflection));
                    worst_length = worst_length.max((path.length_m / length_m - 1.0).abs());
                    let gain = unfolded_gain(wall, length_m, order, across / length_m);
                    worst_gain = worst_gain.max((path.gain / gain - 1.0).norm());
                    count += 1;
                }
            }
        }
    }
    eprintln!(
        "canyon, orders 0 to {ORDERS}: {count} paths, lengths {worst_length:.1e}, gains {worst_gain:.1e}"
    );
    assert!(worst_length < 1e-13 && worst_gain < 1e-9);
}
