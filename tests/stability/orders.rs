//! Many reflections and diffractions: closed forms up to order 50, and limits where paths multiply
//! without end.

use aps_raytrace::glam::DVec2;
use aps_raytrace::{
    ConfigError, Footprint, Material, PathRecord, SPEED_OF_LIGHT_M_PER_S, TerminalError,
    TraceConfig, TraceError, Tracer,
};
use aps_tests::double_complex::{DoubleComplex, spherical_wave};
use aps_tests::double_double::{DoubleDouble, dd};
use aps_tests::links::with_chains;
use aps_tests::shapes::{block, moved, rectangle, ring, scene};
use aps_tests::utd::{MATERIALS, Radio};

const FREQUENCY_HZ: f64 = 3.5e9;

/// Relative error of a path's length, and of its gain.
fn errors(path: &PathRecord, length_m: DoubleDouble, gain: DoubleComplex) -> [f64; 2] {
    let length = (dd(path.length_m) - length_m).abs() / length_m;
    let gain = DoubleComplex::from(path.gain).relative_error(gain);
    [length.to_f64(), gain]
}

/// Images across two walls `size` apart, of a source at `from`: distance from `to`, and number of reflections.
fn images(from: f64, to: f64, size: f64, orders: i32) -> impl Iterator<Item = (f64, i32)> {
    (-orders..=orders).flat_map(move |k| {
        let shift = 2.0 * f64::from(k) * size;
        let even = (shift + from - to, (2 * k).abs());
        [even, (shift - from - to, (2 * k - 1).abs())]
    })
}

/// A street between two perfectly conducting walls, to order 50: 101 paths, two of each order, from
/// the images at 2 k w +- y. Lengths and gains against 32 digits: the phase of 850 m is 6e4 rad, of
/// which a double keeps 7e-12.
///
/// Truncation: images of order n are at least (n - 1) w away, so all orders beyond R together add at
/// most 2 (lambda / 4 pi w)^2 / (R - 1) of power. Tested against the sum over 100,000 orders.
#[test]
fn canyon_of_perfect_conductors_to_order_fifty() {
    const ORDERS: i32 = 50;
    let (width, y, x, v) = (17.0, 3.0, 20.0, 11.0);
    for turn in [DVec2::X, DVec2::from_angle(0.7)] {
        let bars = [-1.0, width].map(|y| rectangle(-1e3, y, 1e3, y + 1.0));
        let scene = scene(&moved(&bars, |p| turn.rotate(p)));
        let config = TraceConfig {
            material: Material::PerfectConductor,
            ..TraceConfig::reflections_only(ORDERS as usize)
        };
        let tracer = Tracer::new(&scene, config).unwrap();
        let at = |x: f64, y: f64| turn.rotate(DVec2::new(x, y));
        let paths = tracer.trace(at(-10.0, y), at(x - 10.0, v)).unwrap().paths;
        assert_eq!(paths.len(), 2 * ORDERS as usize + 1);
        let images = |orders| images(y, v, width, orders);
        let mut worst = [0.0_f64; 2];
        for (across, order) in images(ORDERS).filter(|i| i.1 <= ORDERS) {
            let length_m = DoubleDouble::hypot(dd(x), dd(across));
            let nearest = |p: &&PathRecord| (p.length_m - length_m.to_f64()).abs();
            let path = paths
                .iter()
                .min_by(|p, q| nearest(p).total_cmp(&nearest(q)))
                .unwrap();
            assert_eq!(path.interactions.len() as i32, order);
            let sign = dd(if order % 2 == 0 { 1.0 } else { -1.0 });
            let gain = spherical_wave(length_m, FREQUENCY_HZ) * sign.into();
            let found = errors(path, length_m, gain);
            worst = [worst[0].max(found[0]), worst[1].max(found[1])];
        }
        let amplitude_m = SPEED_OF_LIGHT_M_PER_S / FREQUENCY_HZ / (4.0 * std::f64::consts::PI);
        let traced: f64 = paths.iter().map(PathRecord::power).sum();
        let all: f64 = images(50_000)
            .map(|(across, _)| amplitude_m.powi(2) / (x * x + across * across))
            .sum();
        let bound = 2.0 * (amplitude_m / width).powi(2) / (f64::from(ORDERS) - 1.0);
        eprintln!(
            "canyon, order {ORDERS}: lengths {:.1e}, gains {:.1e}; left out {:.2e} of the power, bound {:.2e}",
            worst[0],
            worst[1],
            (all - traced) / all,
            bound / all
        );
        assert!(worst[0] < 3e-14 && worst[1] < 3e-9);
        assert!(all - traced > 0.0 && all - traced < bound);
    }
}

/// A courtyard closed on all sides, to order 20: 4 n images of order n in a lattice, 841 paths, each
/// with its product of reflection coefficients.
///
/// Truncation: walls of concrete take at least 4 dB of a wave that goes round, so that each order is
/// weaker than the one before by more than its 4 n paths add; orders beyond R are less than what
/// order R has. With perfect conductors the sum of powers has no limit (4 n / n^2): there
/// `max_reflections` is part of the model.
#[test]
fn closed_courtyard_is_a_lattice_of_images() {
    const ORDERS: i32 = 20;
    let (w, h) = (31.0, 19.0);
    let (tx, rx) = (DVec2::new(7.3, 4.1), DVec2::new(21.9, 15.7));
    let around = ring([-5.0, w + 5.0], [-5.0, h + 5.0]);
    let scene = scene(&[block(around, ring([0.0, w], [0.0, h]))]);
    for (material, wall) in MATERIALS {
        let config = TraceConfig {
            material,
            ..TraceConfig::reflections_only(ORDERS as usize)
        };
        let tracer = Tracer::new(&scene, config).unwrap();
        let paths = tracer.trace(tx, rx).unwrap().paths;
        assert_eq!(paths.len(), 841);
        let radio = Radio::of(wall);
        let mut worst = [0.0_f64; 2];
        let mut by_order = [0.0; ORDERS as usize + 1];
        for (dx, nx) in images(tx.x, rx.x, w, ORDERS) {
            for (dy, ny) in images(tx.y, rx.y, h, ORDERS).filter(|i| nx + i.1 <= ORDERS) {
                let length_m = DoubleDouble::hypot(dd(dx), dd(dy));
                let length = length_m.to_f64();
                let gamma = radio.reflection((dx.abs() / length).acos()).powi(nx)
                    * radio.reflection((dy.abs() / length).acos()).powi(ny);
                let gain = spherical_wave(length_m, FREQUENCY_HZ) * gamma.into();
                // Among paths of one order and nearly one length, the one with this gain.
                let (found, path) = paths
                    .iter()
                    .filter(|p| p.interactions.len() as i32 == nx + ny)
                    .filter(|p| (p.length_m / length - 1.0).abs() < 1e-12)
                    .map(|p| (errors(p, length_m, gain), p))
                    .min_by(|p, q| p.0[1].total_cmp(&q.0[1]))
                    .unwrap();
                worst = [worst[0].max(found[0]), worst[1].max(found[1])];
                by_order[(nx + ny) as usize] += path.power();
            }
        }
        let total: f64 = by_order.iter().sum();
        let level: Vec<f64> = by_order
            .iter()
            .map(|p| 10.0 * (p / total).log10())
            .collect();
        eprintln!(
            "courtyard of {material:?}: lengths {:.1e}, gains {:.1e}; power by order [dB] {level:.1?}",
            worst[0], worst[1]
        );
        assert!(worst[0] < 1e-14 && worst[1] < 1e-9);
        if material == Material::Concrete {
            for r in 1..ORDERS as usize {
                assert!(by_order[r + 1..].iter().sum::<f64>() < by_order[r], "{r}");
            }
            assert!(by_order[11..].iter().sum::<f64>() < 1e-4 * total);
        }
    }
}

/// A winding corridor whose walls face each other in many pairs: images multiply by several with
/// each order. Up to order 50 there are more than any machine holds. The limit is met before its
/// memory is taken and named together with the order it was met at; one order less fits, and has
/// the paths of that order, complete.
#[test]
fn corridor_where_images_explode_meets_a_stated_limit() {
    // A saw-tooth corridor, 4 m wide, in one block.
    let teeth =
        |y: f64| (0..=12).map(move |i| DVec2::new(5.0 * f64::from(i), y + 2.0 * f64::from(i % 2)));
    let mut corridor: Vec<DVec2> = teeth(10.0).collect();
    corridor.extend(teeth(14.0).collect::<Vec<_>>().into_iter().rev());
    let scene = scene(&[block(ring([-10.0, 70.0], [0.0, 30.0]), corridor)]);
    let (tx, rx) = (DVec2::new(2.0, 12.5), DVec2::new(55.0, 13.3));
    let mut last = 0;
    for max_images in [100, 1_000, 10_000, 100_000] {
        let config = |max_reflections| TraceConfig {
            max_images,
            ..TraceConfig::reflections_only(max_reflections)
        };
        let tracer = Tracer::new(&scene, config(50)).unwrap();
        let error = tracer.transmitter(tx).unwrap_err();
        let TerminalError::TooManyImages {
            order,
            limit,
            position,
        } = error
        else {
            panic!("{error}");
        };
        assert_eq!((limit, position), (max_images, tx));
        assert!(order > last && order < 50, "{error}");
        let fits = Tracer::new(&scene, config(order - 1)).unwrap();
        let prepared = fits.transmitter(tx).unwrap();
        eprintln!(
            "corridor, at most {max_images} images: order {order} is too much, {} below",
            prepared.image_count()
        );
        assert!(prepared.image_count() <= max_images);
        assert!(matches!(
            tracer.trace(tx, rx),
            Err(TraceError::Transmitter(TerminalError::TooManyImages { .. }))
        ));
        last = order;
    }
}

/// Diffractions multiply as images do: two corners of one house pass a wave to and fro. Each place
/// where memory would grow has a limit with an error that says what to change, and a limit that is
/// not met changes nothing.
#[test]
fn waves_between_corners_meet_a_stated_limit() {
    let house = scene(&[rectangle(0.0, 0.0, 12.0, 10.0)]);
    let config = TraceConfig {
        max_reflections: 0,
        max_diffractions: 1000,
        max_interactions: 1000,
        max_wave_bytes: 1 << 22,
        ..with_chains()
    };
    let tracer = Tracer::new(&house, config).unwrap();
    let error = tracer.transmitter(DVec2::new(-5.0, 3.0)).unwrap_err();
    assert!(
        matches!(error, TerminalError::TooManyWaves { limit, .. } if limit == 1 << 22),
        "{error}"
    );
    assert!(error.to_string().contains("max_diffractions"));

    let city: Vec<Footprint> = (0..36)
        .map(|i| {
            let (x, y) = (20.0 * f64::from(i % 6), 20.0 * f64::from(i / 6));
            rectangle(x, y, x + 10.0, y + 10.0)
        })
        .collect();
    let scene = scene(&city);
    let (tx, rx) = (DVec2::new(15.0, 15.0), DVec2::new(93.0, 112.0));
    for max_diffractions in [1, 2] {
        let config = |max_wave_bytes| TraceConfig {
            max_diffractions,
            max_wave_bytes,
            ..with_chains()
        };
        let unlimited = Tracer::new(&scene, config(usize::MAX))
            .unwrap()
            .trace(tx, rx)
            .unwrap();
        let (mut refused, mut traced) = ([0; 3], 0);
        for bits in 10..32 {
            for limit in [1 << bits, 3 << (bits - 1)] {
                match Tracer::new(&scene, config(limit)).map(|tracer| tracer.trace(tx, rx)) {
                    Err(ConfigError::TooManyWaves { .. }) => refused[0] += 1,
                    Ok(Err(TraceError::Transmitter(_) | TraceError::Receiver(_))) => {
                        refused[1] += 1
                    }
                    Ok(Err(TraceError::TooManyChains { .. })) => refused[2] += 1,
                    Ok(Ok(link)) => {
                        assert_eq!(link.paths, unlimited.paths);
                        traced += 1;
                    }
                    Err(e) => panic!("{e}"),
                    Ok(Err(e)) => panic!("{e}"),
                }
            }
        }
        eprintln!(
            "up to {max_diffractions} diffractions: {refused:?} limits refused by map, terminal, chains; {traced} traced"
        );
        assert!(refused[0] > 5 && traced > 5);
    }
}
