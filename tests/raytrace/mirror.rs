//! A mirrored scene has mirrored spectra: what training on mirror images takes for granted.

use aps_label::{Array, LabelConfig, Labeler, Protocol};
use aps_raytrace::glam::DVec2;
use aps_raytrace::scene::Location;
use aps_raytrace::{Footprint, Link, Tracer};
use aps_tests::links::{outdoor_points, sample, with_chains};
use aps_tests::shapes::{city, moved, scene};

const SIDE_M: f64 = 256.0;

/// Rounding of paths and of the sums over them, relative to the spectrum's largest value.
const ROUNDING: f64 = 1e-8;

/// Spectra of all links between `points`, linear and relative to each one's largest value.
fn spectra(footprints: &[Footprint], points: &[DVec2], label: &LabelConfig) -> Vec<Vec<f64>> {
    let scene = scene(footprints);
    let tracer = Tracer::new(&scene, with_chains()).unwrap();
    let labeler = Labeler::new(label).unwrap();
    let (tx, rx) = points.split_at(points.len() / 2);
    let mut link = Link::default();
    let mut all = Vec::new();
    for &tx in tx {
        let tx = tracer.transmitter(tx).unwrap();
        for &rx in rx {
            let rx = tracer.receiver(rx).unwrap();
            tracer.link(&tx, &rx, &mut link).unwrap();
            let paths: Vec<_> = link.paths.iter().map(sample).collect();
            let label = labeler.label(&paths).unwrap();
            let db = label.map_or(Vec::new(), |label| label.aps_db);
            let top = db.iter().copied().fold(f64::MIN, f64::max);
            let power = |x: f64| libm::exp10(0.1 * (x - top));
            all.push(db.into_iter().map(power).collect());
        }
    }
    all
}

/// Largest difference, with the bins of the second in reverse order or not.
fn difference(a: &[Vec<f64>], b: &[Vec<f64>], is_reversed: bool) -> f64 {
    let bin = |j: usize, bins: usize| if is_reversed { bins - 1 - j } else { j };
    let of_link = |(a, b): (&Vec<f64>, &Vec<f64>)| {
        assert_eq!(a.len(), b.len(), "a link lost its label");
        let pairs = a.iter().enumerate().map(|(j, x)| (x, b[bin(j, b.len())]));
        pairs.fold(0.0, |worst: f64, (x, y)| worst.max((x - y).abs()))
    };
    a.iter().zip(b).map(of_link).fold(0.0, f64::max)
}

#[test]
fn spectra_of_a_linear_array_follow_the_mirror() {
    let footprints = city(256, 5).footprints().unwrap();
    let scene = scene(&footprints);
    // Off the grid of walls: on it a ray through a corner is one side's or the other's.
    let points: Vec<DVec2> = outdoor_points(&scene, 40, 3)
        .into_iter()
        .map(|p| p + DVec2::new(0.317, 0.441))
        .filter(|&p| scene.locate(p) == Location::Outdoor)
        .collect();
    assert!(points.len() > 20);
    let released = LabelConfig::of(Protocol::Released);
    let upright = spectra(&footprints, &points, &released);
    assert!(upright.iter().filter(|s| !s.is_empty()).count() > 100);
    let circular = LabelConfig {
        array: Array::UniformCircular {
            elements: 8,
            radius_wavelengths: 0.5,
        },
        ..released.clone()
    };
    let of_circular = spectra(&footprints, &points, &circular);

    for (along_x, along_y) in [(true, false), (false, true), (true, true)] {
        let turn = |p: DVec2| {
            let x = if along_x { SIDE_M - p.x } else { p.x };
            let y = if along_y { SIDE_M - p.y } else { p.y };
            DVec2::new(x, y)
        };
        let turned = moved(&footprints, turn);
        let ends: Vec<DVec2> = points.iter().map(|&p| turn(p)).collect();
        let found = difference(&upright, &spectra(&turned, &ends, &released), along_y);
        assert!(found < ROUNDING, "x {along_x}, y {along_y}: {found:e}");
        // A circular array tells left from right.
        if along_x {
            let found = spectra(&turned, &ends, &circular);
            assert!(difference(&of_circular, &found, along_y) > 0.1);
        }
    }
}
