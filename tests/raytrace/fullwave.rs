//! The field of whole scenes against the solution of the wave equation (`tests/golden/fullwave`).

use aps_raytrace::{Complex64, Link, TraceConfig, Tracer};
use aps_tests::fullwave::{FullWave, Walls, line_source_field};
use aps_tests::links::corners;

/// Fields that much below those of free space are not compared: down to -80 dB the reference is good to 0.13 dB.
const FLOOR: f64 = 1e-4;

fn limits(reflections: usize, diffractions: usize, slope_diffraction: bool) -> TraceConfig {
    TraceConfig {
        slope_diffraction,
        dynamic_range_db: None,
        ..TraceConfig::within(reflections, diffractions)
    }
}

/// Errors of the level [dB] of the links whose strongest path has at least so many corners, and the number of links without a path.
fn errors(
    name: &str,
    walls: Walls,
    limits: TraceConfig,
    least_corners: usize,
) -> (Vec<f64>, usize) {
    let full = FullWave::named(name);
    let scene = full.scene().unwrap();
    let tracer = Tracer::new(&scene, walls.config(limits)).unwrap();
    let (mut errors, mut missing) = (Vec::new(), 0);
    let mut link = Link::default();
    for (i, &source) in full.sources().iter().enumerate() {
        let tx = tracer.transmitter(source).unwrap();
        for (&place, truth) in full.receivers().iter().zip(full.fields(walls, i)) {
            if truth.norm() * source.distance(place).sqrt() < FLOOR {
                continue;
            }
            let rx = tracer.receiver(place).unwrap();
            tracer.link(&tx, &rx, &mut link).unwrap();
            let strongest = link
                .paths
                .iter()
                .max_by(|p, q| p.power().total_cmp(&q.power()));
            match strongest {
                None => missing += 1,
                Some(path) if corners(path) >= least_corners => {
                    let field: Complex64 = link.paths.iter().map(line_source_field).sum();
                    errors.push(20.0 * (field.norm() / truth.norm()).log10().abs());
                }
                Some(_) => {}
            }
        }
    }
    (errors, missing)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// One house, one corner: what is left is the error of the theory at the corner, which falls with the size in wavelengths.
#[test]
fn around_one_conducting_house_the_level_is_right() {
    for (name, most_db) in [
        ("block05", 0.15),
        ("block10", 0.08),
        ("block20", 0.04),
        ("block40", 0.02),
    ] {
        let (errors, missing) = errors(name, Walls::Conductor, limits(2, 1, false), 0);
        eprintln!("{name}: {:.3} dB in the mean", mean(&errors));
        assert!(
            missing == 0 && mean(&errors) < most_db,
            "{name}: {errors:?}"
        );
    }
}

/// Luebbers' heuristic for finite conductivity, and the reference's impedance in place of Fresnel's coefficient.
#[test]
fn around_one_house_of_concrete_the_level_is_a_heuristic() {
    for name in ["block05", "block10", "block20", "block40"] {
        let (errors, missing) = errors(name, Walls::Concrete, limits(2, 1, false), 0);
        eprintln!("{name}: {:.3} dB in the mean", mean(&errors));
        assert!(missing == 0 && mean(&errors) < 1.6, "{name}");
    }
}

/// Behind two corners the level is right only with slopes: along a wall there is nothing without them, and a corner in the transition region of
/// another is wrong by much.
#[test]
fn slopes_carry_waves_around_two_corners() {
    for (name, walls, most_db, least_gain_db) in [
        ("terrace", Walls::Conductor, 1.2, 3.0),
        ("terrace", Walls::Concrete, 2.6, 2.0),
        ("behind", Walls::Conductor, 7.0, 2.5),
        ("behind", Walls::Concrete, 3.0, 8.0),
        ("courtyard", Walls::Concrete, 2.0, 3.0),
    ] {
        let [without, with] =
            [false, true].map(|slopes| errors(name, walls, limits(4, 2, slopes), 2));
        let means = [&without.0, &with.0].map(|errors| mean(errors));
        eprintln!(
            "{name}, {}: {:.2} dB over {} links, {:.2} dB over {} with slopes; without a path {} and {}",
            walls.name(),
            means[0],
            without.0.len(),
            means[1],
            with.0.len(),
            without.1,
            with.1
        );
        assert!(means[1] < most_db && means[1] + least_gain_db < means[0]);
        assert!(with.1 <= without.1);
    }
}

/// A courtyard with a gate: out of it, along its walls of perfect conductor, no ray gets without slopes.
#[test]
fn waves_leave_a_conducting_courtyard_along_its_walls() {
    let [without, with] =
        [false, true].map(|slopes| errors("courtyard", Walls::Conductor, limits(4, 2, slopes), 2));
    eprintln!("{} links without a path, {} with slopes", without.1, with.1);
    assert!(without.0.is_empty() && with.1 < without.1);
    assert!(
        with.0.len() > 20 && mean(&with.0) < 2.5,
        "{}",
        mean(&with.0)
    );
}
